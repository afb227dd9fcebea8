"""The consoles at the width of a phone, in the language with the longer words: no word is cut, nothing is covered."""

import pytest
from playwright.sync_api import expect

from tests.e2e.conftest import session
from tests.e2e.drawn import settle
from tests.e2e.test_layout import OVER
from tests.e2e.test_stage import portal as portal

PHONE = {"width": 390, "height": 844}
CUT = """(selector) => [...document.querySelectorAll(selector)]
  .filter((e) => e.checkVisibility() && (e.scrollWidth > e.clientWidth || e.scrollHeight > e.clientHeight)).map((e) => e.textContent)"""


def drives(portal, visitor, robot, locale, wide=390):
    """Return a browser whose page drives the robot."""
    user = portal.person("ada", robot)
    portal.drive(user, robot)
    one = session(visitor(locale=locale, viewport={**PHONE, "width": wide}), user)
    page = one.page
    page.goto(portal.robots[robot].get_absolute_url())
    page.wait_for_selector(".operating")
    return one


@pytest.mark.parametrize("locale", ["de-DE", "en-US"])
@pytest.mark.parametrize("robot", ["pa10", "puma"])
def test_no_word_of_the_view_and_of_the_head_is_cut(portal, visitor, robot, locale):
    one = drives(portal, visitor, robot, locale)
    page = one.page
    page.click("#tab-scene")
    expect(page.locator("#ghost-tools")).to_be_visible()
    settle(page)
    assert page.evaluate(CUT, "#ghost-tools button, #model .button, .view, .robot-head h1, #state") == []
    assert page.locator("#ghost-tools").bounding_box()["height"] < 46


@pytest.mark.parametrize("locale", ["de-DE", "en-US"])
@pytest.mark.parametrize("wide", [320, 360])
@pytest.mark.parametrize("robot", ["mercury", "pa10", "puma", "srv1"])
def test_on_the_narrowest_phones_too_no_button_and_no_state_is_cut(portal, visitor, robot, wide, locale):
    page = drives(portal, visitor, robot, locale, wide).page
    settle(page)
    assert page.evaluate(CUT, "#robot .button, .view, .robot-head h1, #state, .simulated") == []
    assert page.evaluate(OVER) == []


@pytest.mark.parametrize("locale", ["de-DE", "en-US"])
@pytest.mark.parametrize("down", [0, 300])
def test_a_notice_leaves_the_banner_uncovered(portal, visitor, locale, down):
    one = drives(portal, visitor, "mercury", locale)
    page = one.page
    page.evaluate("(down) => scrollTo({ top: down, behavior: 'instant' })", down)
    one.allowed = ("ERR_INTERNET_DISCONNECTED",)
    page.context.set_offline(True)
    banner, notice = page.locator("#banner"), page.locator("#notice")
    expect(banner).to_be_visible()
    page.locator("[data-command=up]").evaluate("(button) => button.click()")
    expect(notice).to_be_visible()
    settle(page)
    above, other = banner.bounding_box(), notice.bounding_box()
    assert above["y"] + above["height"] <= other["y"] or other["y"] + other["height"] <= above["y"], (above, other)
    assert other["y"] + other["height"] <= page.locator("#stage-bar").bounding_box()["y"]
