"""The whole way of somebody who has never been here: from the landing page to a motion, the log and the survey.

Everything is pressed where it is shown, with a mouse or a finger; what it takes is counted by the page itself.
"""

import re

import pytest
from playwright.sync_api import expect

from accounts.models import Choice
from operatorlog.models import Entry, SurveyResponse
from tests.e2e.conftest import confirmation
from tests.e2e.test_whole_way import end_turn, survey  # noqa: F401 - a fixture

DESKTOP = {"viewport": {"width": 1440, "height": 900}}
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
COUNT = "addEventListener('pointerdown', (event) => { if (event.isTrusted) counted() }, true);"
FOCUS = "() => document.activeElement.tagName"
PRESSES = 17  # from the landing page to the first motion, with every answer right


class Newcomer:
    """Somebody with a browser, who presses what is shown; their presses are counted."""

    def __init__(self, visitor, touches):
        self.presses = 0
        self._touches = touches
        self.page = visitor.page
        visitor.context.expose_function("counted", self._counted)
        visitor.context.add_init_script(COUNT)

    def _counted(self):
        self.presses += 1

    def press(self, what, within="body"):
        """Press a link, a button or a choice that the page shows."""
        found = self.page.locator(within).locator(what).locator("visible=true").first
        expect(found).to_be_visible()
        found.tap() if self._touches else found.click()

    def fill(self, fields):
        for name, text in fields.items():
            self.page.fill(f"[name={name}]", text)


@pytest.mark.parametrize("look", [DESKTOP, PHONE], ids=["desktop", "phone"])
def test_a_newcomer_comes_to_a_motion_and_into_the_log(portal, visitor, survey, look):  # noqa: F811
    one = visitor(**look)
    new, page = Newcomer(one, "has_touch" in look), one.page
    page.goto("/")
    expect(page.locator("main")).to_contain_text("Simulated")
    new.press("a[href='/robots/mercury/']", "main")
    expect(page.locator(".robot-head")).to_contain_text("Simulated")
    expect(page.locator("#watchers")).to_have_text(re.compile("^(, only you watch)?$"))
    new.press("#place a >> text=Sign up")
    new.fill(
        {
            "email": "ada@example.org",
            "username": "ada",
            "password1": "correct horse 42",
            "password2": "correct horse 42",
        }
    )
    new.press("main button[type=submit]")
    page.wait_for_url("**/confirm-email/")
    page.goto(confirmation("ada@example.org"))
    new.press("main button")
    page.wait_for_load_state()
    new.press("a[href='/robots/mercury/']")
    new.press("#place a")
    page.wait_for_url("**/orientation/")
    expect(page.locator("main")).to_contain_text("I'm here")
    expect(page.locator("main")).not_to_contain_text("at rest")
    new.press("main form button")
    page.wait_for_selector("main input[type=radio]")
    for choice in Choice.objects.filter(correct=True).values_list("pk", flat=True):
        answer = page.locator(f"input[type=radio][value='{choice}']")
        if answer.count():
            new.press(f"input[type=radio][value='{choice}']")
    new.press("main form button")
    page.wait_for_url("**/robots/mercury/")
    new.press("[data-do=join]")
    expect(page.locator("[data-do=accept]")).to_be_visible()
    assert page.evaluate(FOCUS) != "BODY"
    new.press("[data-do=accept]")
    down = page.locator("[data-command=down]")
    expect(down).to_have_attribute("aria-disabled", "false")
    assert page.evaluate(FOCUS) != "BODY"
    new.press("[data-command=down]")
    one.ladder()
    first_motion = new.presses
    stop = page.locator("[data-command=stop]").locator("visible=true").first
    at = stop.bounding_box()
    new.press("[data-command=stop]")
    expect(page.locator("#release")).to_be_visible()
    assert stop.bounding_box() == at
    new.press("#checked")
    new.press("[data-command=release]")
    expect(page.locator("#release")).to_be_hidden()
    end_turn(page)
    expect(page.locator("#place")).to_contain_text("You ended it")
    assert page.evaluate(FOCUS) != "BODY"
    page.click("text=Write in the operator's log")
    page.fill("#text", "The sand took the mark of the nozzle.\r\nIt stays there.")
    page.locator("input[type=radio][name^=s]").first.check()
    page.click("main form button")
    expect(page.locator("main")).to_contain_text("It is in the log")
    assert Entry.objects.count() == SurveyResponse.objects.count() == 1
    print(f"{first_motion} presses to the first motion")
    assert first_motion <= PRESSES
