"""Positions on the page: Stop is reachable and uncovered, nothing scrolls sideways, nothing jumps under a finger."""

import pytest
from playwright.sync_api import expect

from tests.conftest import at_length
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session
from tests.e2e.drawn import QUIET, blocks, scroll, settle, size

PHONES = [(390, 844), (360, 640), (844, 390)]
WIDTHS = [360, 390, 768, 1024, 1440]
MODES = ["joint", "position", "program", "terminal"]
# what lies on top in the middle of the element; empty where it is the element itself or inside it
COVER = """(element) => {
  const box = element.getBoundingClientRect();
  const at = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
  return at && element.contains(at) ? "" : `${at ? at.outerHTML.slice(0, 120) : "off the screen"} at ${box.x},${box.y}`;
}"""
# the texts of the card of keys that its button to close it covers
BESIDE_CLOSE = """(card) => {
  const close = card.querySelector("button").getBoundingClientRect();
  return [...card.querySelectorAll("h2, p, dt, dd")].filter((text) => {
    const range = document.createRange();
    range.selectNodeContents(text);
    return [...range.getClientRects()].some((box) => box.left < close.right && box.right > close.left && box.top < close.bottom && box.bottom > close.top);
  }).map((text) => text.textContent);
}"""
# where the buttons stand with each of the hints, all looked at within one task of the page
PLACES = """(hints) => hints.map((words) => {
  scrollTo({top: 0, behavior: "instant"});
  document.getElementById("why").textContent = words;
  return [...document.querySelectorAll("#controls .button")].map((b) => Object.values(b.getBoundingClientRect().toJSON()));
})"""

# the links of the person's place, and where they stand: now, and before anything has come over the socket
PLACE_LINKS = """() => [...document.querySelectorAll("#place a")].map((a) => [a.textContent, a.getAttribute("href"), ...Object.values(a.getBoundingClientRect().toJSON())])"""
FIRST = f"document.addEventListener('DOMContentLoaded', () => {{ window.first = ({PLACE_LINKS})(); }})"

STAGE = """() => [...document.querySelectorAll(".robot-head, #stage, #stage-view, #stage-bar, #place")].map((e) => Object.values(e.getBoundingClientRect().toJSON()))"""

SHIFTED = 0.05  # of what a layout shift counts: half of what is called good
SHIFTS = """window.shifts = []; new PerformanceObserver((list) => {
  for (const { value, sources } of list.getEntries()) shifts.push([value, ...sources.map(({ node }) => node && node.outerHTML.slice(0, 80))]);
}).observe({ type: "layout-shift", buffered: true });"""


@pytest.fixture
def driving(portal, visitor):
    """Give somebody a turn at a robot, in a browser of their own."""

    def make(robot, name="ada", **options):
        user = portal.person(name, robot)
        turn = portal.drive(user, robot)
        one = session(visitor(**options), user)
        one.turn = turn
        one.page.goto(portal.robots[robot].get_absolute_url())
        one.page.wait_for_selector(".operating")
        one.page.evaluate(QUIET)
        return one

    return make


def scrolled(page):
    """Stand at the top, half-way and at the end of the page, one after the other."""
    for share in (0, 0.3, 0.6, 1):
        scroll(page, share)
        yield share


def test_stop_is_in_reach_and_uncovered_in_every_mode_of_the_arm(driving):
    page = driving("pa10", color_scheme="dark").page
    page.select_option("#pace", "coarse")  # blocks come when they are asked for
    stop = page.locator("[data-command=stop]")
    for wide, high in PHONES:
        size(page, wide, high)
        for mode in MODES:
            page.evaluate("(mode) => document.getElementById('tab-' + mode).click()", mode)
            if mode == "program":
                blocks(page)
            for share in scrolled(page):
                where = (wide, high, mode, share)
                assert stop.evaluate(COVER) == "", where
                if wide < high and share < 0.6:
                    assert page.locator("#screen").evaluate(COVER) == "", where


@pytest.mark.parametrize("robot", [at_length("mercury"), "pa10"])
def test_stop_is_in_reach_and_works_beside_the_card_of_keys(driving, portal, robot):
    one = driving(robot)
    page = one.page
    stop = page.locator("[data-command=stop]")
    card = page.locator("#keys")
    for wide, high in [*PHONES, (1440, 900)]:
        size(page, wide, high)
        page.click("#keys-open")
        expect(card).to_be_visible()
        assert page.evaluate("() => document.querySelectorAll(':modal').length") == 0
        for share in scrolled(page):
            assert stop.evaluate(COVER) == "", (wide, high, share)
        assert card.evaluate(BESIDE_CLOSE) == [], (wide, high)
        card.get_by_role("button", name="Close", exact=True).focus()
        page.keyboard.press("Escape")
        expect(card).to_be_hidden()
        assert not stopped(portal, robot), "Escape closes the card, and no more"
    page.click("#keys-open")
    one.axe("the card of keys")
    card.get_by_role("button", name="Close", exact=True).focus()
    page.keyboard.press("s")
    expect(page.locator("#release")).to_be_visible()
    assert stopped(portal, robot), "the key of Stop works while the card is open"


def stopped(portal, robot):
    return type(portal.robot).objects.get(pk=portal.robots[robot].pk).stop_latched


@pytest.mark.timed
def test_a_field_in_the_blocks_is_edited_in_place_below_stop(driving):
    """A prompt of the browser's own would be modal, over Stop too."""
    page = driving("pa10", has_touch=True, is_mobile=True, user_agent="Mozilla/5.0 (Linux; Android 14) Mobile", viewport={"width": 390, "height": 844}).page  # fmt: skip
    asked = []
    page.on("dialog", lambda dialog: (asked.append(dialog.message), dialog.dismiss()))
    page.evaluate("() => document.getElementById('tab-program').click()")
    field = page.locator(".blocklyEditableField").first
    expect(field).to_be_visible()
    field.scroll_into_view_if_needed()
    page.evaluate("() => scrollBy(0, 200)")
    field.tap()
    expect(page.locator(".blocklyHtmlInput")).to_be_visible()
    assert asked == []
    assert page.locator("[data-command=stop]").evaluate(COVER) == ""


LIGHTNESS = """(selector) => {
  const words = (element, name) => getComputedStyle(element)[name].match(/[\\d.]+/g).map(Number);
  const light = ([r, g, b]) => [r, g, b].map((v) => v / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4))
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const element = document.querySelector(selector);
  let behind = element;
  while (behind && /^rgba\\(0, 0, 0, 0\\)$/.test(getComputedStyle(behind).backgroundColor)) behind = behind.parentElement;
  const [a, b] = [light(words(element, "color")), light(words(behind, "backgroundColor"))].sort((x, y) => y - x);
  return { contrast: (a + 0.05) / (b + 0.05), behind: light(words(behind, "backgroundColor")) };
}"""


@pytest.mark.timed
@pytest.mark.parametrize("scheme", [at_length("light"), "dark"])
def test_the_blocks_follow_the_colours_of_the_page(driving, scheme):
    one = driving("pa10", color_scheme=scheme)
    page = one.page
    page.click("#tab-program")
    blocks(page)
    words = page.evaluate(LIGHTNESS, ".blocklyToolboxCategoryLabel")
    assert words["contrast"] >= 4.5
    for selector in (".blocklyToolbox", ".blocklyMainWorkspaceScrollbar ~ * , .blocklySvg"):
        behind = page.evaluate(LIGHTNESS, selector.split(" , ")[-1])["behind"]
        assert (behind < 0.1) == (scheme == "dark"), (selector, behind)


def test_image_and_controls_stay_together_on_a_small_phone(driving):
    page = driving("mercury").page
    size(page, 360, 640)
    page.locator("#screen").scroll_into_view_if_needed()
    page.mouse.wheel(0, 300)
    settle(page)
    for selector in ("#screen", "[data-command=go]", "[data-command=stop]"):
        box = page.locator(selector).bounding_box()
        assert box["y"] >= 0, selector
        assert box["y"] + box["height"] <= 640, selector
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 360
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    for button in page.locator("#controls .button").all():
        assert button.bounding_box()["height"] >= 44


@pytest.mark.parametrize(("robot", "tab"), [("mercury", ""), ("pa10", "#tab-position")])
def test_what_a_finger_holds_is_at_least_44_px_large(driving, robot, tab):
    page = driving(robot).page
    size(page, 360, 640)
    if tab:
        page.click(tab)
    found = page.locator("[data-jog]").locator("visible=true")
    assert found.count() >= 4
    for button in found.all():
        box = button.bounding_box()
        assert min(box["width"], box["height"]) >= 44, button.inner_text()


def test_no_robot_page_scrolls_sideways(driving):
    pages = [driving("mercury").page, driving("pa10", "bob").page]
    for page in pages:
        for wide in WIDTHS:
            size(page, wide, 900)
            for mode in MODES if page.locator("#modes").count() else [""]:
                if mode:
                    page.evaluate("(mode) => document.getElementById('tab-' + mode).click()", mode)
                over = page.evaluate(OVER)
                assert over == [], (page.url, wide, mode, over)


# nothing sticks out of the page, nor out of the card that it stands in; the line that says who drives ends with an
# ellipsis where there is no room
OVER = """() => {
  const wide = document.documentElement.clientWidth;
  const found = document.documentElement.scrollWidth > wide ? ["the page scrolls sideways"] : [];
  for (const e of document.querySelectorAll("main *, header *, footer *, .turnbar *")) {
    const box = e.getBoundingClientRect();
    // what a closed part hides has the place of when it was drawn last
    if (!box.width || !e.checkVisibility() || e.closest(".visually-hidden, svg, .blocks, .table-wrap, .trace, [hidden], .who > *")) continue;
    if (box.right > wide + 1 || box.left < -1) found.push(`${e.outerHTML.slice(0, 80)} to ${box.right}`);
  }
  for (const e of document.querySelectorAll(".side > *, .table-wrap"))
    if (e.scrollWidth > e.clientWidth + 1) found.push(`${e.outerHTML.slice(0, 80)} overhangs by ${e.scrollWidth - e.clientWidth}`);
  const side = document.querySelector(".side")?.getBoundingClientRect();
  for (const e of document.querySelectorAll(".side > *")) {
    const { width, left, right } = e.getBoundingClientRect();
    if (width && (right > side.right + 1 || left < side.left - 1)) found.push(`${e.ariaLabel} overhangs its column`);
  }
  return found.slice(0, 5);
}"""


HINTS = [
    "",
    "Enter or “Move here” sends the arm: about eleven bursts here.",
    "Click in the camera image or in the map to choose where to go.",
    "The robot has moved since that picture; click in the newest one.",
    "The live link to the robot is down; nothing moves until it is back. Your turn is kept.",
    "The connection is lost; the page tries to connect again. Your turn is kept for 20 seconds.",
]


@pytest.mark.parametrize("robot", ["mercury", "pa10"])
@pytest.mark.parametrize(("wide", "high"), [(390, 844), (1440, 900)])
def test_a_strangers_page_stands_still_as_the_robot_is_heard_of(portal, visitor, robot, wide, high):
    page = visitor(viewport={"width": wide, "height": high}).page
    page.add_init_script(FIRST)
    page.add_init_script(SHIFTS)
    page.goto(portal.robots[robot].get_absolute_url())
    expect(page.locator("#watchers")).not_to_be_empty()  # it has been told of its robot
    expect(page.locator("#place a", has_text="Sign up")).to_be_visible()
    assert page.evaluate("first") == page.evaluate(PLACE_LINKS)
    settle(page)
    shifts = page.evaluate("shifts")
    assert sum(value for value, *_ in shifts) < SHIFTED, shifts


@pytest.mark.parametrize(("wide", "high"), [(390, 844), (1440, 900)])
def test_the_way_to_driving_moves_nothing_of_the_stage(portal, visitor, wide, high):
    page = session(visitor(viewport={"width": wide, "height": high}), portal.person("ada", "mercury")).page
    page.goto(portal.robots["mercury"].get_absolute_url())
    expect(page.locator("#place button", has_text="Take control")).to_be_visible()
    settle(page)
    way = page.locator(".side .way")
    expect(way.locator("[aria-current=step]")).to_have_text("Drive")
    boxes = [link.bounding_box() for link in way.locator("a").all()]
    assert all(box["height"] >= 43.9 for box in boxes), boxes
    assert len({round(box["y"]) for box in boxes}) == 1, "in one line"
    shown = page.evaluate(STAGE)
    way.evaluate("(e) => { e.hidden = true; e.style.display = 'none'; }")
    settle(page)
    assert page.evaluate(STAGE) == shown


@pytest.mark.parametrize("robot", ["mercury", at_length("pa10")])
def test_the_buttons_stand_still_whatever_the_hint_says(driving, robot):
    page = driving(robot).page
    for wide, high in [*PHONES, (768, 1024), (1440, 900)]:
        size(page, wide, high)
        seen = {str(places) for places in page.evaluate(PLACES, HINTS)}
        assert len(seen) == 1, (wide, high, seen)
