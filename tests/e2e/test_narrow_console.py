"""The consoles at the width of a phone, in the language with the longer words: no word is cut, nothing is covered."""

import pytest
from playwright.sync_api import expect

from tests.e2e.conftest import session
from tests.e2e.drawn import QUIET, settle, size
from tests.e2e.test_layout import OVER
from tests.e2e.test_stage import WHERE
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


# whether these words of a line are within its place; empty if they are
WHOLE = """([selector, words]) => {
  const line = document.querySelector(selector), range = document.createRange(), at = line.textContent.indexOf(words);
  if (at < 0) return line.textContent;
  range.setStart(line.firstChild, at);
  range.setEnd(line.firstChild, at + words.length);
  const { top, bottom } = range.getBoundingClientRect(), place = line.getBoundingClientRect();
  return top >= place.top - 1 && bottom <= place.bottom + 1 ? "" : `${words} is cut: ${bottom} is below ${place.bottom}`;
}"""


FAR = "Wählen Sie einen anderen Ort."
PLACES = {
    ("pa10", 390, 844, "table"): [((0.25, 0.62), "Drücken Sie „Los“."), ((0.02, 0.95), FAR)],
    ("puma", 844, 390, "front"): [((0.5, 0.6), "Wählen Sie ein Objekt.")],  # of a robot whose pictures nobody looks at
}


@pytest.mark.parametrize("where", PLACES, ids=lambda where: where[0])
def test_of_a_chosen_place_the_verdict_is_read_first_and_all_of_it_at_a_press(portal, visitor, where):
    robot, wide, high, camera = where
    page = drives(portal, visitor, robot, "de-DE").page
    size(page, wide, high)
    page.evaluate(QUIET)
    said, screen = page.locator("#pick-said"), page.locator("#screen")
    page.click(f"[data-name={camera}]")
    expect(page.locator("#screen.aimed")).to_be_attached()
    settle(page)
    for (across, down), verdict in PLACES[where]:
        box = screen.bounding_box()
        screen.click(position={"x": across * box["width"], "y": down * box["height"]})
        expect(said).to_contain_text(verdict)
        assert page.evaluate(WHOLE, ["#pick-said", verdict]) == ""
        if "Los" not in verdict:
            expect(page.locator("#why")).to_contain_text(verdict)
            assert page.evaluate(WHOLE, ["#why", verdict]) == ""
        for line in ("#pick-said", "#why"):
            if text := page.inner_text(line):
                page.locator(line).scroll_into_view_if_needed()
                settle(page)
                before = page.evaluate(WHERE)
                page.click(line)
                assert page.evaluate(WHOLE, [line, text]) == ""
                assert page.evaluate(WHERE) == before
    if robot == "pa10":
        page.click("[data-name=gripper]")
        screen.click()
        expect(said).to_contain_text("Wählen Sie eine andere Kamera")
        assert page.evaluate(WHOLE, ["#pick-said", page.inner_text("#pick-said").split(".")[0]]) == ""


def test_go_is_named_only_until_it_is_pressed(portal, visitor):
    page = drives(portal, visitor, "pa10", "en-US").page
    page.click("[data-name=table]")
    expect(page.locator("#screen.aimed")).to_be_attached()
    box = page.locator("#screen").bounding_box()
    page.locator("#screen").click(position={"x": 0.25 * box["width"], "y": 0.62 * box["height"]})
    said = page.locator("#pick-said")
    expect(said).to_contain_text(" s. Press Go. The table, ")
    page.click("[data-command=go-pick]")
    expect(said).to_contain_text(" s. The table, ")
