"""People who move the ghost of the tool by keys, by mouse and by finger, as its list in words says."""

import re
from functools import partial
from math import remainder

import numpy as np
import pytest
from playwright.sync_api import expect

from robots.kit.description import load
from tests.e2e.frames import read

KEPT_UP = {"ping", "here", "watch"}  # that a page lives, that its person is there, which pictures its line allows
AT_THE_ARM = "The ghost is at the arm"
PLACE = re.compile(r"x, y, z (−?-?\d+), (−?-?\d+), (−?-?\d+) mm")
YAW = re.compile(r"yaw \S+, \S+, (−?-?\d+)°")
SNAP_DEG = 2  # within which the ghost snaps
MISSING = re.compile(r"(-?\d+)(?: mm|°) (about z|\w+)")
MOVED_M = 0.005  # a brick lies 1 mm beside its place in the description at first
STEPS = (1, 1), (5, 5), (20, 15)  # mm and degrees of a key or a button; a larger one is asked about
AXES = ("forward", "back"), ("left", "right"), ("up", "down")
TURNS = "about z", "back about z"
WAYS = {  # by key, and by button
    "forward": ("ArrowUp", "x +"), "back": ("ArrowDown", "x −"), "left": ("ArrowLeft", "y +"),
    "right": ("ArrowRight", "y −"), "up": ("PageUp", "z +"), "down": ("PageDown", "z −"),
    "about z": ("Shift+ArrowLeft", "↻ z"), "back about z": ("Shift+ArrowRight", "↺ z"),
}  # fmt: skip
BETWEEN_MS = 30  # between two keys, of which one that waited long is left out
LOOK_MS = 250  # until the list has followed
DRAWN_MS = 800  # until a pointer meets what another viewpoint shows, without a graphics card
ROUNDS = 12  # in which a place is reached, though keys are left out and the ghost snaps
MIDDLE = np.array([0.35, 0.0, 0.3])  # what the viewpoints look at (m), their places from there, the field of view
FROM = {"Side": np.array([0.0, -2.3, 0.35]), "Top": np.array([-0.02, 0.0, 2.4])}
FIELD = np.radians(38)
# the axes along which a handle moves the ghost there
ACROSS = {"Side": np.array([1, 0, 1]), "Top": np.array([1, 1, 0])}
HANDLE = 0.22 * 1.9 / 4  # of the view's half height at the ghost: from the ghost to such a handle, along both axes
SCALES = {1: 6.0, 5: 2.0}  # of the hand's motion to the ghost's, and how near it is to come (mm)


def place(page):
    """Return where the ghost is (mm), as the list in words says."""
    numbers = PLACE.search(page.locator("#ghost-list").text_content()).groups()
    return np.array([float(text.replace("−", "-")) for text in numbers])


def yaw(page):
    """Return how the ghost is turned about the vertical (degrees), as the list in words says."""
    return int(YAW.search(page.locator("#ghost-list").text_content())[1].replace("−", "-"))


class Wire:
    """The messages that a page sends, and the sockets that it closes, from now on."""

    def __init__(self, page):
        self.sent, self.closed = [], 0
        page.on("websocket", self._opened)

    def _opened(self, socket):
        socket.on("framesent", self._sent)
        socket.on("close", self._closed)

    def _sent(self, payload):
        if said := read(payload):
            self.sent.append(said["t"])

    def _closed(self, _):
        self.closed += 1

    @property
    def kinds(self):
        return set(self.sent) - KEPT_UP


def drive(person, within_ms=30_000):
    """Let a visitor drive the arm, with the scene drawn; return the person, whose `wire` tells what is sent."""
    person.wire = Wire(person.page)
    person.cleared("ada").take_turn()
    expect(person.page.locator("#model canvas")).to_be_visible(timeout=within_ms)
    expect(person.page.locator("#model-said")).to_have_text(AT_THE_ARM, timeout=within_ms)
    return person


def put_back(person, *names):
    """Let a task put bricks of the PUMA back to their first places, the uppermost first: the robot runs on."""
    first = {one["name"]: np.array(one["place"]) for one in load("puma")["object"]}
    there = person.portal.sim.status()["objects"]
    moved = sorted((n for n in names if np.abs(there[n] - first[n]).max() > MOVED_M), key=lambda n: -there[n][2])
    if moved:
        run_task(person, *(f"put {n} at {1000 * first[n][0]:g} {1000 * first[n][1]:g} 0" for n in moved), "move ready")


def run_task(person, *lines):
    """Run a task of these lines, and come back to the scene."""
    page = person.page
    page.click("#tab-task")
    page.fill("#task-text", "\n".join(lines))
    person.give("run-task")
    person.ladder("completed", 180)
    page.click("#tab-scene")


class Keys:
    """Moves the ghost by keys on its handle alone."""

    def __init__(self, person):
        self.person, self.page = person, person.page

    def go(self, target):
        """Bring the ghost to a place (mm), as the list says."""
        for _ in range(ROUNDS):
            way = np.round(np.subtract(target, place(self.page)))
            if np.abs(way).max() < 1:
                break
            for axis in np.argsort(-np.abs(way)):
                self.move(AXES[axis][int(way[axis] < 0)], abs(int(way[axis])))
            self.page.wait_for_timeout(LOOK_MS)
        assert place(self.page) == pytest.approx(target, abs=2), self.page.inner_text("#ghost-list")

    def turn(self, degrees):
        """Turn the ghost about the vertical, as the list says."""
        goal = yaw(self.page) + degrees
        for _ in range(ROUNDS):
            left = round(remainder(goal - yaw(self.page), 360))
            if abs(left) <= SNAP_DEG:
                return
            self.move(TURNS[int(left < 0)], abs(left))
            self.page.wait_for_timeout(LOOK_MS)
        raise AssertionError(self.page.inner_text("#ghost-list"))

    def reach_goal(self, goal):
        """Bring the ghost the last millimetres and degrees to a goal, as the list says in words."""
        for _ in range(ROUNDS):
            words = self.page.inner_text("#ghost-list")
            if re.search(rf"The ghost is at {goal}\.", words):
                return
            found = re.search(rf"To {goal}: (.*)\.", words)
            assert found, f"to {goal}: {words}"
            for size, way in MISSING.findall(found[1]):
                if way == TURNS[0]:
                    self.move(TURNS[int(int(size) < 0)], abs(int(size)))
                elif way in WAYS:
                    self.move(way, int(size))
            self.page.wait_for_timeout(LOOK_MS)
        raise AssertionError(self.page.inner_text("#ghost-list"))

    def move(self, way, far):
        """Move the ghost one way by so much (mm or degrees), in the largest steps first."""
        for size in reversed(range(len(STEPS))):
            times, far = divmod(far, STEPS[size][way in TURNS])
            if times:
                self.step(way, size, times)

    def step(self, way, size, times):
        self.page.focus("#ghost-handle")
        for key in (*["-"] * len(STEPS), *["+"] * size, *[WAYS[way][0]] * times):
            self.page.keyboard.press(key)
            self.page.wait_for_timeout(BETWEEN_MS)


class Mouse(Keys):
    """Pulls the ghost's handles by mouse, and clicks its buttons for the rest."""

    handles = 1.0  # their size

    def go(self, target):
        """Bring the ghost to a place (mm), by the handle that moves it along two axes in one view and in another."""
        for scale, near in SCALES.items():
            self.page.select_option("#ghost-scale", str(scale))
            for view, across in ACROSS.items():
                way = (target - place(self.page)) * across
                if np.abs(way).max() > near:
                    self.page.locator("#viewpoints button", has_text=view).first.click()
                    self.page.wait_for_timeout(DRAWN_MS)
                    self._pull(view, scale * way / 1000)
        off = np.abs(target - place(self.page)).max()
        assert off <= near + 1, f"not {target}: {self.page.inner_text('#ghost-list')}"

    def _pull(self, view, way):
        """Pull the handle in the middle between two axes so far (m)."""
        canvas = self.page.locator("#model canvas")
        canvas.scroll_into_view_if_needed()
        seen = partial(projected, view, canvas.bounding_box())
        ghost = place(self.page) / 1000
        far = np.linalg.norm(MIDDLE + FROM[view] - ghost)
        at = ghost + ACROSS[view] * HANDLE * self.handles * far * half_field(canvas.bounding_box())
        begin, end = seen(at), seen(at + way)
        self.down(begin)
        self.move_to(end)
        self.page.wait_for_timeout(LOOK_MS)
        self.up()
        self.page.wait_for_timeout(LOOK_MS)

    def step(self, way, size, times):
        self.page.select_option("#ghost-step", str(size))
        for _ in range(times):
            self.press(self.page.locator(f"#ghost-pad [aria-label^='{WAYS[way][1]} ']"))

    def press(self, button):
        button.click()

    def down(self, point):
        self.page.mouse.move(*point)
        self.page.mouse.down()

    def move_to(self, point):
        self.page.mouse.move(*point, steps=4)

    def up(self):
        self.page.mouse.up()


class Fingers(Mouse):
    """Pulls them by a finger, and taps the buttons."""

    handles = 1.5

    def __init__(self, person):
        super().__init__(person)
        self._wire = person.context.new_cdp_session(person.page)

    def press(self, button):
        button.tap()

    def _touch(self, what, *points):
        touches = [{"x": float(x), "y": float(y)} for x, y in points]
        self._wire.send("Input.dispatchTouchEvent", {"type": what, "touchPoints": touches})

    def down(self, point):
        self._touch("touchStart", point)

    def move_to(self, point):
        self._touch("touchMove", point)

    def up(self):
        self._touch("touchEnd")


def half_field(box):
    """Return the tangent of half the vertical field of view: one that is higher than wide sees as far to the sides."""
    return np.tan(FIELD / 2) * max(1.0, box["height"] / box["width"])


def projected(view, box, point):
    """Return where a place (m) is seen in a view whose canvas has that box (px)."""
    ahead = -FROM[view] / np.linalg.norm(FROM[view])
    right = np.cross(ahead, [0, 0, 1])
    right /= np.linalg.norm(right)
    way = point - MIDDLE - FROM[view]
    scale = box["height"] / 2 / half_field(box) / (way @ ahead)
    middle = np.array([box["x"] + box["width"] / 2, box["y"] + box["height"] / 2])
    return middle + scale * np.array([way @ right, -way @ np.cross(right, ahead)])
