"""The PUMA 560 in its scene, in a browser: rod and figure by keyboard, mouse and touch, also over 100 bytes/s."""

import numpy as np
import pytest
from playwright.sync_api import expect

from robots.kit.arms.goals import goals_of
from robots.kit.arms.objects import yaw_of
from robots.kit.description import load, programs_of
from robots.models import Robot
from tests.e2e.ghost import AT_THE_ARM, Fingers, Keys, Mouse, drive, put_back, run_task
from tests.e2e.thin_line import ThinLine
from tests.rig import free_port

pytestmark = [pytest.mark.timed, pytest.mark.parametrize("which", ["puma"], indirect=True)]

WIDE = {"viewport": {"width": 1440, "height": 900}}
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
ABOVE, AT, LIFTED = (550, 300, 400), (550, 300, 300), (550, 300, 345)  # mm, of the tool beside the rod
LIFTED_M, NEAR_M = 0.33, 0.001
SEEN_MS = 700  # from Send until the motion is drawn as expected: its path needs 1 s of a line of 100 bytes/s
# how long after each Send the arm is drawn as expected (ms)
EXPECTED = """
() => { window.waits = []; const model = document.getElementById("model"); let sent = null;
  document.addEventListener("keydown", ({ key }) => key === "Enter" && (sent = performance.now()), true);
  new MutationObserver(() => {
    if (sent === null || !model.hasAttribute("data-expected")) return;
    waits.push(performance.now() - sent); sent = null;
  }).observe(model, { attributeFilter: ["data-expected"] }); }
"""
ABOVE_IT = np.array([0, 0, 0.10])  # m
FIGURE = {goal.name: goal for goal in goals_of("puma")}["figure"]
PRESSES = 10
HANDS = {"keys": (Keys, WIDE), "mouse": (Mouse, WIDE), "touch": (Fingers, PHONE)}
FIRST = {one["name"]: np.array(one["place"]) for one in load("puma")["object"]}
GRASP = np.array(load("puma")["object"][0]["grasp"][0]["tool"])  # m, from the middle of a brick to the tool
RELEASE = np.array([0, 0, load("puma")["objects"]["release"]])
TURN_S = 1200


@pytest.fixture
def operator(visitor):
    return lambda **options: drive(visitor(**options))


def send(person):
    """Send the ghost by the keyboard, and wait for the end; while a thin line has told no state for long, press again."""
    person.mark_newest()
    person.page.focus("#ghost-handle")
    for _ in range(PRESSES):
        person.page.keyboard.press("Enter")
        person.page.wait_for_timeout(300)
        if person.newer().count():
            break
        person.page.wait_for_timeout(2000)
    person.ladder("completed", 90)


def lift(person, go):
    """Take the rod and lift it; `go` brings the ghost to a place (mm)."""
    for target in (ABOVE, AT):
        go(target)
        send(person)
    person.press("close")
    go(LIFTED)
    send(person)


def assert_lifted(portal, person):
    """See that the rod was lifted, and let it go again: the robot runs on for the next test."""
    assert portal.sim.status()["objects"]["rod"][2] > LIFTED_M
    person.press("open")


@pytest.mark.parametrize(("hand", "options"), HANDS.values(), ids=HANDS)
def test_the_rod_is_lifted_by_hand(transactional_db, portal, operator, hand, options):
    ada = operator(**options)
    lift(ada, hand(ada).go)
    assert_lifted(portal, ada)
    ada.axe("the PUMA's scene, with the rod")


def test_the_rod_is_lifted_by_a_task(transactional_db, portal, operator):
    ada = operator(**WIDE)
    ada.page.click("#tab-task")
    ada.page.fill("#task-text", "grasp rod\nmove 550 300 345")
    ada.press("run-task")
    assert_lifted(portal, ada)


def build(person, hand):
    """Build the figure of five bricks: take each where it is first, turn it, press it on."""
    for name, goal in FIGURE.parts.items():
        reach(person, hand, FIRST[name] + GRASP, f"the grasp of {name}", "close")
        end = goal[:3, 3] + GRASP + RELEASE
        hand.go(mm(end + ABOVE_IT))
        if abs(yaw_of(goal)) > 1:
            hand.turn(90)
        send(person)
        reach(person, hand, end, "its place in the figure", "open")
        expect(person.page.locator("#goals-list")).to_contain_text(f"✓ {name}: in its place")
        if abs(yaw_of(goal)) > 1:
            hand.turn(-90)


def assert_built(portal, person):
    """See that the figure stands, and that the page says that it is won."""
    there = portal.sim.status()["objects"]
    for name, goal in FIGURE.parts.items():
        assert there[name] == pytest.approx(goal[:3, 3], abs=NEAR_M), name
    expect(person.page.locator("#goals-said")).to_contain_text("The figure of five bricks")


def reach(person, hand, at, goal, grip):
    """From above go down to a goal (m), close or open the gripper, and go up again."""
    hand.go(mm(at + ABOVE_IT))
    send(person)
    hand.go(mm(at))
    hand.reach_goal(goal)
    send(person)
    person.press(grip)
    hand.go(mm(at + ABOVE_IT))
    send(person)


def mm(place):
    return np.round(np.array(place) * 1000)


@pytest.mark.parametrize(("hand", "options"), HANDS.values(), ids=HANDS)
def test_the_figure_is_built_by_hand_and_won(transactional_db, portal, operator, hand, options):
    Robot.objects.update(turn_s=TURN_S)
    ada = operator(**options)
    put_back(ada, *FIRST)
    build(ada, hand(ada))
    assert_built(portal, ada)


@pytest.fixture
def over_thin_line(portal, visitor):
    """A person whose page was loaded well, over a line that then has 100 bytes/s and a round trip of 0.3 s."""
    line = ThinLine(("127.0.0.1", free_port()), ("127.0.0.1", portal.web.port))
    ada = visitor(**WIDE).cleared("ada", address=None)
    ada.allowed, ada.line = ("ERR_", "WebSocket", "Failed to load"), line
    page = ada.page
    page.goto(f"http://localhost:{line.at[1]}/robots/puma/")
    Robot.objects.update(turn_s=TURN_S)
    ada.take_turn()
    expect(page.locator("#model canvas")).to_be_visible(timeout=60_000)
    expect(page.locator("#model-said")).to_have_text(AT_THE_ARM, timeout=30_000)
    page.select_option("#pace", "states")
    page.wait_for_timeout(1000)
    expect.set_options(timeout=60_000)
    line.thin(100, 0.3)
    yield ada
    line.close()


def test_over_100_bytes_a_second_and_with_the_line_cut_the_ghost_goes_on(transactional_db, portal, over_thin_line):
    ada = over_thin_line
    page = ada.page
    pictures = []
    page.on("request", lambda request: pictures.append(request.url) if request.url.endswith(".jpg") else None)
    page.evaluate(EXPECTED)
    lift(ada, Keys(ada).go)
    assert page.evaluate("() => waits.length && Math.max(...waits)") < SEEN_MS, (
        "the motion is drawn as expected at once"
    )
    assert_lifted(portal, ada)
    assert pictures == [], "a picture keeps everything else back"
    ada.line.set("cut")
    before = portal.sim.status()["q"]
    Keys(ada).go((560, 280, 400))
    expect(page.locator("#ghost-list")).to_contain_text("Place: x, y, z 560, 280, 400 mm")
    assert portal.sim.status()["q"] == pytest.approx(before, abs=1e-3), "nothing moves while the line is cut"
    expect(page.locator("body")).to_contain_text("Connection lost", timeout=60_000)


def test_over_100_bytes_a_second_the_figure_is_built_by_keys(transactional_db, portal, over_thin_line):
    ada = over_thin_line
    put_back(ada, *FIRST)
    build(ada, Keys(ada))
    assert_built(portal, ada)


def test_over_100_bytes_a_second_the_figure_is_built_by_a_task(transactional_db, portal, over_thin_line):
    ada = over_thin_line
    put_back(ada, *FIRST)
    run_task(ada, *dict(programs_of("puma", "task"))["The figure of five bricks"].splitlines())
    expect(ada.page.locator("#task-blocks")).to_contain_text("Over this slow line the blocks are not loaded")
    assert_built(portal, ada)
