"""Pages that are read from right to left: nothing sticks out of them, and what has a left and a right keeps both."""

import pytest
from playwright.sync_api import expect

from operatorlog.models import Visibility
from tests.e2e.conftest import session
from tests.e2e.drawn import size
from tests.e2e.pages import OWN, PUBLIC, known, without
from tests.e2e.recorded import recording as recording
from tests.e2e.stage import assert_in_view
from tests.e2e.test_axe import NARROW, WIDE
from tests.e2e.test_layout import OVER
from tests.e2e.test_stage import BAR, BESIDE, drives
from tests.e2e.test_stage import portal as portal

FOR_STAFF = ["/admin/", "/survey/results/"]
SIZES = [(1440, 900), (390, 844), (844, 390)]
# before the page's own scripts run
TURNED = """new MutationObserver((_, observer) => {
  if (!document.documentElement) return;
  document.documentElement.dir = "rtl";
  observer.disconnect();
}).observe(document, { childList: true })"""

LEFT_TO_RIGHT = [
    "<svg/>",
    "<canvas/>",
    "<code/>",
    "<kbd/>",
    "<input type=number>",
    "<input type=email>",
    "<input type=range min=-1>",
]
RIGHT_TO_LEFT = ["<p/>", "<input>", "<input type=range min=0>"]
# which way those go that a console would bring
DIRECTIONS = """(made) => made.map((html) => {
  const main = document.getElementById("main");
  main.insertAdjacentHTML("beforeend", html);
  return getComputedStyle(main.lastElementChild).direction;
})"""


@pytest.fixture
def visitor(visitor):
    """Open browsers whose pages are all read from right to left."""

    def make(**options):
        one = visitor(**options)
        one.context.add_init_script(TURNED)
        return one

    return make


def fits(one, addresses):
    """See that nothing sticks out of these pages, on a desktop and on a phone."""
    for address in addresses:
        answer = one.page.goto(address)
        assert answer.ok, address
        if one.page.locator("#state").count():
            expect(one.page.locator("#state")).not_to_be_empty()  # it has been told of its robot
        assert one.page.evaluate("getComputedStyle(document.body).direction") == "rtl"
        for shown in (WIDE, NARROW):
            size(one.page, shown["width"], shown["height"])
            assert one.page.evaluate(OVER) == [], (address, shown)


def test_nothing_sticks_out_of_a_page_for_all(portal, visitor, recording):
    cy = portal.person("cy", "mercury", "pa10")
    portal.entry(cy, "mercury", visibility=Visibility.FEATURED)
    entry = portal.entry(cy, "pa10", "w" * 300)
    anybody = visitor()
    anybody.allowed = ("/mercury/camera/0.jpg",)  # in a frame of another site; nothing sees now
    fits(anybody, without(known(PUBLIC, turn=entry.turn.pk)))
    own = known(OWN, new="rover").values()
    fits(session(visitor(), recording.turn.user), [recording.get_absolute_url(), *own])


def test_nothing_sticks_out_of_a_page_of_staff(portal, visitor):
    portal.entry(portal.person("cy", "mercury"), "mercury")
    root = portal.person("root", is_staff=True, is_superuser=True)
    one = session(visitor(), root)
    fits(one, FOR_STAFF)
    one.page.goto(f"/admin/robots/robot/{portal.robots['pa10'].pk}/change/")
    for field in ("#id_address", "#id_camera", ".boxes-editor + textarea"):
        assert one.page.locator(field).evaluate("(field) => getComputedStyle(field).direction") == "ltr", field


@pytest.mark.parametrize("robot", ["mercury", "srv1"])
def test_whatever_control_is_used_the_stage_stays(portal, visitor, robot):
    page = drives(portal, visitor, robot)
    expect(page.locator(f"{BESIDE[robot]} *").first).to_be_attached()
    assert_in_view(page, ["#screen", BESIDE[robot], *BAR], SIZES)
    views, controls = (page.locator(part).bounding_box() for part in ("#stage-view", ".stage-body"))
    assert views["x"] > controls["x"], "one begins at the right"


def test_what_is_written_from_left_to_right_in_each_language_stays_so(portal, visitor):
    page = visitor().page
    page.goto("/")
    assert page.evaluate(DIRECTIONS, LEFT_TO_RIGHT) == ["ltr"] * len(LEFT_TO_RIGHT)
    assert page.evaluate(DIRECTIONS, RIGHT_TO_LEFT) == ["rtl"] * len(RIGHT_TO_LEFT)


def middle(place):
    box = place.bounding_box()
    return box["x"] + box["width"] / 2


def test_left_is_left_in_a_picture_and_on_a_pad(portal, visitor):
    page = drives(portal, visitor, "mercury")
    screen = page.locator("#screen").bounding_box()
    at = {"x": screen["width"] * 0.3, "y": screen["height"] * 0.6}
    page.locator("#screen").click(position=at)
    cross = page.locator("#screen .cross")
    expect(cross).to_be_visible()
    assert abs(middle(cross) - screen["x"] - at["x"]) < 3
    page.locator("#screen").press("Shift+ArrowLeft")
    assert middle(cross) < screen["x"] + at["x"] - 3
    assert middle(page.locator("[data-jog='-1,0']")) < middle(page.locator("[data-jog='1,0']"))


def test_a_tab_is_chosen_by_the_arrow_that_points_at_it(portal, visitor):
    page = drives(portal, visitor, "pa10")
    scene, joint = page.locator("#tab-scene"), page.locator("#tab-joint")
    assert middle(joint) < middle(scene)
    scene.press("ArrowLeft")
    expect(joint).to_have_attribute("aria-selected", "true")
    joint.press("ArrowRight")
    expect(scene).to_have_attribute("aria-selected", "true")


def test_a_joints_slider_is_negative_on_its_left(portal, visitor):
    page = drives(portal, visitor, "pa10")
    page.click("#tab-joint")
    row = page.locator(".joint").first
    slider = row.locator("input[type=range]")
    low, high = (float(slider.get_attribute(name)) for name in ("min", "max"))
    box = slider.bounding_box()
    slider.click(position={"x": box["width"] * 0.25, "y": box["height"] / 2})
    assert float(slider.input_value()) == pytest.approx(low + 0.25 * (high - low), abs=0.05 * (high - low))
    was = float(slider.input_value())
    slider.press("ArrowRight")
    assert float(slider.input_value()) > was
    mark = middle(row.locator("i"))  # where the joint is: in the middle, at 0
    assert abs(mark - middle(slider)) < 0.02 * box["width"] + 2
    assert middle(row.locator("[data-jog$=',-1']")) < middle(row.locator("[data-jog$=',1']"))


def test_time_runs_to_the_right_in_a_recording(portal, visitor, recording):
    page = session(visitor(), recording.turn.user).page
    page.goto(recording.get_absolute_url())
    bar = page.locator("#replay-at")
    expect(bar).to_be_enabled()
    box = bar.bounding_box()
    bar.click(position={"x": box["width"] * 0.75, "y": box["height"] / 2})
    assert float(bar.input_value()) == pytest.approx(0.75 * float(bar.get_attribute("max")), rel=0.1)
    failed = page.locator("#replay-marks rect.bad").bounding_box()
    assert failed["x"] < middle(bar), "it failed at 8 s of 24 s"
