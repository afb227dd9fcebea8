"""The menu of every page: one row whatever the number of robots, by mouse, by finger and by keyboard."""

import pytest
from playwright.sync_api import expect

from robots.models import Robot
from tests.e2e.bare import portal as portal

ROW_PX = 64  # the height of one row
MANY = 24
LOOKS = {
    "desktop": {"viewport": {"width": 1440, "height": 900}},
    "tablet": {"viewport": {"width": 768, "height": 1024}, "color_scheme": "dark"},
    "phone": {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True},
}


@pytest.fixture
def many(portal):
    Robot.objects.bulk_create(
        Robot(slug=f"robot-{n}", name=f"Robot with a long name {n}", driver="mercury", address=f"sim:{n}", enabled=True)
        for n in range(MANY)
    )


@pytest.mark.parametrize("look", LOOKS.values(), ids=LOOKS)
def test_the_navigation_is_one_row_and_leads_to_every_robot(many, portal, visitor, look):
    one = visitor(**look).cleared("ada", None)
    page = one.page
    page.goto("/story/")
    assert page.locator(".site-head").bounding_box()["height"] <= ROW_PX
    assert page.evaluate("document.documentElement.scrollWidth") == look["viewport"]["width"]
    menu, robots = page.locator(".menu-open"), page.locator(".menu-robots summary")
    if "has_touch" in look:
        expect(robots).to_be_hidden()
        menu.tap()
    robots.click()
    last = page.locator(".menu-robots a").last
    last.scroll_into_view_if_needed()
    expect(last).to_be_in_viewport(ratio=1)
    one.axe("the open menu")
    last.click()
    page.wait_for_url("**/robots/**")


def test_the_menu_closes_by_escape_and_by_a_press_elsewhere(portal, visitor):
    page = visitor(viewport={"width": 1440, "height": 900}).page
    page.goto("/story/")
    robots = page.locator(".menu-robots")
    for close in (lambda: page.keyboard.press("Escape"), lambda: page.click("h1")):
        page.focus(".menu-robots summary")
        page.keyboard.press("Enter")
        expect(robots).to_have_attribute("open", "")
        close()
        expect(robots).not_to_have_attribute("open", "")
    page.focus(".menu-robots summary")
    page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.closest('.menu-robots a') !== null"), "the first robot is next"
    page.keyboard.press("Escape")
    assert page.evaluate("document.activeElement.matches('.menu-robots summary')")


def test_a_phones_menu_closes_by_escape_and_leaves_the_question_of_a_turn_in_sight(portal, visitor):
    one = visitor(**LOOKS["phone"]).cleared("ada", None)
    portal.drive(one.user, "mercury")
    page = one.page
    page.goto("/robots/mercury/")
    page.wait_for_selector(".operating")
    page.tap(".menu-open")
    expect(page.locator("#menu")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.locator("#menu")).to_be_hidden()
    one.follow_menu("Status")
    expect(page.locator("#turnbar")).to_contain_text("Leave in the middle of your turn?")
    expect(page.locator("#menu")).to_be_hidden()
