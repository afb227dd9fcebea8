"""The PUMA 560 in its scene, in a browser: the rod by keyboard, mouse, touch and task, also over a line of 100 bytes/s."""

import re

import numpy as np
import pytest
from playwright.sync_api import expect

from robots.kit.arms.goals import goals_of
from robots.kit.description import load, programs_of
from tests.e2e.ghost import AT_THE_ARM, KEYS, Fingers, Mouse, drive, place, put_back, run_task
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
PUTS = [
    line for line in dict(programs_of("puma", "task"))["The figure of five bricks"].splitlines() if line[:3] == "put"
]
PRESSES = 10
MISSING = re.compile(r"\nTo .*?(\d+) mm (\w+)")
BUTTONS = {"forward": "x +", "back": "x −", "left": "y +", "right": "y −", "up": "z +", "down": "z −"}


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


def by_keys(page):
    """Return what brings the ghost to a place by its keys alone: the list says how far it still is."""

    def go(target):
        page.focus("#ghost-handle")
        for _ in range(2):
            page.keyboard.press("+")
        for step in (20, 5, 1):
            way = np.subtract(target, place(page))
            for axis in np.argsort(-np.abs(way)):
                count = round(abs(way[axis]) / step) if step == 1 else int(abs(way[axis]) // step)
                for _ in range(count):
                    page.keyboard.press(KEYS[axis][int(way[axis] < 0)])
            page.keyboard.press("-")
        assert place(page) == pytest.approx(target, abs=2), page.inner_text("#ghost-list")

    return go


def test_the_rod_is_lifted_by_keyboard_alone(transactional_db, portal, operator):
    ada = operator(**WIDE)
    lift(ada, by_keys(ada.page))
    assert_lifted(portal, ada)
    ada.axe("the PUMA's scene, with the rod")


def test_the_rod_is_lifted_by_a_task(transactional_db, portal, operator):
    ada = operator(**WIDE)
    ada.page.click("#tab-task")
    ada.page.fill("#task-text", "grasp rod\nmove 550 300 345")
    ada.press("run-task")
    assert_lifted(portal, ada)


@pytest.mark.parametrize(("hand", "options"), [(Mouse, WIDE), (Fingers, PHONE)], ids=["mouse", "touch"])
def test_the_rod_is_lifted_by_a_pointer(transactional_db, portal, operator, hand, options):
    ada = operator(**options)
    lift(ada, hand(ada).go)
    assert_lifted(portal, ada)


def by_buttons(page):
    """Turn the ghost by its buttons, by so many degrees about z."""
    page.select_option("#ghost-step", "2")
    for _ in range(6):
        page.click("[aria-label='↻ z: Turn the ghost about z']")


def nudge(page):
    """Bring the ghost the last millimetres by its buttons, as the list in words says."""
    page.select_option("#ghost-step", "0")
    for _ in range(12):
        words = page.inner_text("#ghost-list")
        if "The ghost is at" in words:
            return
        if way := MISSING.search(words):
            page.click(f"[aria-label^='{BUTTONS[way[2]]}:']")
        page.wait_for_timeout(200)  # the list follows once a frame
    raise AssertionError(page.inner_text("#ghost-list"))


def mm(place):
    return np.round(np.array(place) * 1000)


def last_brick(person, go):
    """Put the fifth brick of the figure onto the others: take it, turn it, press it on."""
    objects = load("puma")["objects"]
    start = next(one["place"] for one in load("puma")["object"] if one["name"] == "e")
    grasp_z = 0.001  # the tool is so much higher than the middle of a brick
    there, end = np.add(start, [0, 0, grasp_z]), FIGURE.parts["e"][:3, 3] + [0, 0, grasp_z + objects["release"]]
    reach(person, go, there, "close")
    go(mm(end + ABOVE_IT))
    by_buttons(person.page)
    send(person)
    reach(person, go, end, "open")


def reach(person, go, at, grip):
    """From above go down to a place (m), close or open the gripper, and go up again."""
    go(mm(at + ABOVE_IT))
    send(person)
    go(mm(at))
    nudge(person.page)
    send(person)
    person.press(grip)
    go(mm(at + ABOVE_IT))
    send(person)


@pytest.mark.parametrize(
    ("hand", "options"), [(by_keys, WIDE), (Mouse, WIDE), (Fingers, PHONE)], ids=["keys", "mouse", "touch"]
)
def test_the_figure_is_finished_by_hand_and_won(transactional_db, portal, operator, hand, options):
    ada = operator(**options)
    page = ada.page
    if page.locator("#goals-list", has_text="✓ d: in its place").count():
        put_back(ada, "e")
    else:
        run_task(ada, *PUTS[:4], "move ready")
    expect(page.locator("#goals-list")).to_contain_text("✓ d: in its place")
    last_brick(ada, hand(page) if hand is by_keys else hand(ada).go)
    there = portal.sim.status()["objects"]
    assert there["e"] == pytest.approx(np.add(there["d"], [0, 0, 0.0192]), abs=NEAR_M)
    expect(page.locator("#goals-list")).to_contain_text("✓ e: in its place")
    expect(page.locator("#goals-said")).to_contain_text("The figure of five bricks")


def test_over_100_bytes_a_second_and_with_the_line_cut_the_ghost_goes_on(transactional_db, portal, visitor):
    line = ThinLine(("127.0.0.1", free_port()), ("127.0.0.1", portal.web.port))
    ada = visitor(**WIDE).cleared("ada", address=None)
    ada.allowed = ("ERR_", "WebSocket", "Failed to load")
    page = ada.page
    pictures = []
    page.on("request", lambda request: pictures.append(request.url) if request.url.endswith(".jpg") else None)
    page.goto(f"http://localhost:{line.at[1]}/robots/puma/")
    ada.take_turn()
    expect(page.locator("#model canvas")).to_be_visible(timeout=60_000)
    expect(page.locator("#model-said")).to_have_text(AT_THE_ARM, timeout=30_000)
    page.select_option("#pace", "states")
    page.wait_for_timeout(1000)
    pictures.clear()
    line.thin(100, 0.3)
    page.evaluate(EXPECTED)
    lift(ada, by_keys(page))
    assert page.evaluate("() => waits.length && Math.max(...waits)") < SEEN_MS, (
        "the motion is drawn as expected at once"
    )
    assert_lifted(portal, ada)
    assert pictures == [], "a picture keeps everything else back"
    line.set("cut")
    before = portal.sim.status()["q"]
    by_keys(page)((560, 280, 400))
    expect(page.locator("#ghost-list")).to_contain_text("Place: x, y, z 560, 280, 400 mm")
    assert portal.sim.status()["q"] == pytest.approx(before, abs=1e-3), "nothing moves while the line is cut"
    expect(page.locator("body")).to_contain_text("Connection lost", timeout=60_000)
    line.close()
