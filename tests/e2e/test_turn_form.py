"""Ending a turn, which is asked twice, and the form after it, whose text is never lost."""

import re

import pytest
from playwright.sync_api import expect

from operatorlog.models import Entry, SurveyAnswer
from queueing.models import Turn
from tests.conftest import wait_for
from tests.e2e.bare import BarePortal
from tests.e2e.conftest import session
from tests.e2e.test_turn_panel import QUIET

LOADED = "() => [...document.querySelectorAll('.entry img, .frames img')].every((i) => i.complete && i.naturalWidth)"


@pytest.fixture
def portal(transactional_db, redis_server, house):
    made = BarePortal(house.web_process(FARHAND_QUIZ_PAUSE_S="4"))
    yield made
    made.stop()


def at_rest(locator):
    """Return an element's place, once nothing above it comes or goes any more."""
    seen = [None]

    def same():
        seen.append(locator.bounding_box())
        locator.page.wait_for_timeout(100)
        return len(seen) > 5 and all(box == seen[-1] for box in seen[-5:])

    wait_for(same, 15, "a page at rest")
    return seen[-1]


def test_ending_the_turn_is_asked_in_place_and_what_is_written_is_never_lost(portal, visitor):
    ada = portal.person("ada", "mercury")
    turn = portal.drive(ada, "mercury")
    one = visitor()
    session(one, ada)
    page = one.page
    page.goto("/robots/mercury/")
    page.wait_for_selector(".operating")
    page.evaluate(QUIET)
    end = page.locator("#place [data-do=leave]")
    before = at_rest(end)
    end.dblclick()
    expect(end).to_have_text("Press again to end it")
    expect(page.locator("#place")).to_contain_text("You cannot undo this")
    after = at_rest(end)
    assert (after["x"], after["y"], after["height"]) == (before["x"], before["y"], before["height"])
    one.axe("asked")
    assert Turn.objects.get(pk=turn.pk).ended_at is None, "a double click is one press"
    expect(end).to_have_text("End my turn", timeout=12_000)
    end.click()
    page.wait_for_timeout(600)
    end.click()
    page.click("text=Write in the operator's log")
    page.wait_for_url(f"**{turn.get_absolute_url()}")  # loaded: its script stores what is typed from now on
    # typed and left: it is there again
    page.fill("#text", "A watch, at half past four.")
    page.locator("input[type=radio][name^=s]").nth(3).check()
    page.locator("textarea[name^=s]").fill("to dig in winter")
    page.goto("/")
    page.goto(turn.get_absolute_url())
    expect(page.locator("#text")).to_have_value("A watch, at half past four.")
    expect(page.locator("textarea[name^=s]")).to_have_value("to dig in winter")
    expect(page.locator("input[type=radio][name^=s]").nth(3)).to_be_checked()
    # refused by the server: nothing is lost, nothing is saved
    page.evaluate(
        "() => { const t = document.getElementById('text'); t.removeAttribute('maxlength'); t.value = 'y'.repeat(2001); }"
    )
    page.click("main form.form button")
    expect(page.locator("[role=alert]")).to_contain_text("at most 2000 characters")
    assert len(page.input_value("#text")) == 2001
    expect(page.locator("textarea[name^=s]")).to_have_value("to dig in winter")
    one.allowed = ("422",)
    assert not Entry.objects.exists()
    page.fill("#text", "A watch.")
    page.click("main form.form button")
    expect(page.locator(".messages")).to_contain_text("your answers are kept")
    assert Entry.objects.get().text == "A watch."
    assert SurveyAnswer.objects.count() == 2
    page.wait_for_function("() => !Object.keys(localStorage).some((k) => k.startsWith('draft'))")  # its script has run
    page.wait_for_function(LOADED)
    shown = page.locator(".entry img").evaluate(
        "(i) => [i.clientWidth / i.clientHeight, i.naturalWidth / i.naturalHeight]"
    )
    assert shown[0] == pytest.approx(shown[1], rel=0.02)
    for ratio in page.locator(".frames img").evaluate_all(
        "(all) => all.map((i) => i.clientWidth / i.clientHeight * i.naturalHeight / i.naturalWidth)"
    ):
        assert ratio == pytest.approx(1, rel=0.02)


def test_try_again_counts_down_and_then_works(portal, visitor):
    from accounts.bank import load_bank
    from accounts.models import Choice, OrientationRead
    from robots.clock import SYSTEM

    eve = portal.person("eve")
    load_bank(portal.robot)
    OrientationRead.objects.create(user=eve, robot=portal.robot, at=SYSTEM.now())
    one = visitor()
    session(one, eve)
    page = one.page
    page.goto("/robots/mercury/clearance/")
    wrong = set(Choice.objects.filter(correct=False).values_list("pk", flat=True))
    for group in page.locator("main fieldset").all():
        next(box for box in group.locator("input").all() if int(box.get_attribute("value")) in wrong).check()
    page.click("main form button")
    again = page.locator("a[data-pause]")
    expect(again).to_have_text(re.compile(r"Try again in 0:0\d"))
    expect(again).to_have_attribute("aria-disabled", "true")
    here = page.content()
    again.click(force=True)
    assert "Not yet" in here
    one.axe("waiting")
    expect(again).to_have_text("Try again", timeout=15_000)
    expect(page.locator("#pause-said")).to_have_text("You can try again now.")
    again.click()
    expect(page.locator("main form fieldset").first).to_be_visible()


def test_without_scripts_the_pause_is_a_sentence(portal, visitor):
    from accounts.bank import load_bank
    from accounts.models import OrientationRead
    from robots.clock import SYSTEM

    eve = portal.person("eve")
    load_bank(portal.robot)
    OrientationRead.objects.create(user=eve, robot=portal.robot, at=SYSTEM.now())
    one = visitor(java_script_enabled=False)
    session(one, eve)
    page = one.page
    page.goto("/robots/mercury/clearance/")
    for group in page.locator("main fieldset").all():
        group.locator("input").last.check()
    page.click("main form button")
    expect(page.locator("main")).to_contain_text(re.compile(r"You can try again in \d+ seconds?"))
    expect(page.locator("a[data-pause]")).to_have_text("Try again")
