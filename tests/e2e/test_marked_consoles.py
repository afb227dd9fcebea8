"""Each robot's console in the pseudo-language, for who drives and who watches: no text is left in English."""

import pytest
from playwright.sync_api import expect

from tests.e2e.conftest import session
from tests.e2e.test_languages import unmarked
from tests.e2e.test_stage import ALL
from tests.e2e.test_stage import portal as portal

OPEN = "() => { for (const more of document.querySelectorAll('details')) more.open = true; }"


@pytest.mark.parametrize("robot", [name for name in ALL if name != "irat"])
def test_no_text_of_a_console_is_unmarked_while_one_drives(portal, visitor, robot):
    ada = portal.person("ada", robot)
    portal.drive(ada, robot)
    page = session(visitor(locale="ar-XB"), ada).page
    page.goto(portal.robots[robot].get_absolute_url())
    expect(page.locator("#place .timer")).to_be_visible()
    tabs = page.locator("#stage [role=tab]")
    found = {}
    for number in range(max(1, tabs.count())):
        if tabs.count():
            tabs.nth(number).click()
        page.evaluate(OPEN)
        for text in unmarked(page):
            found[text] = tabs.nth(number).inner_text() if tabs.count() else ""
    page.locator("#screen").focus()
    page.keyboard.press("?")
    expect(page.locator("#keys")).to_be_visible()
    found |= dict.fromkeys(unmarked(page), "keys")
    assert not found, "\n".join(f"{where}: {text!r}" for text, where in found.items())


def test_no_text_of_a_robots_page_is_unmarked_for_who_watches(portal, visitor):
    one = visitor(locale="ar-XB")
    one.allowed = ("503",)  # nobody takes pictures
    page, found = one.page, {}
    for robot in portal.robots.values():
        for address in (robot.get_absolute_url(), f"/embed/robots/{robot.slug}/"):
            page.goto(address)
            expect(page.locator("#state, .embed p").first).not_to_be_empty()
            page.evaluate(OPEN)
            if texts := unmarked(page):
                found[address] = texts
    assert not found, "\n".join(f"{address}: {text!r}" for address, texts in found.items() for text in texts)
