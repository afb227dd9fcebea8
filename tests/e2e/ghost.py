"""Hands for the ghost of the tool: where it is, as its list says, and pulling it by mouse or by finger."""

import re

import numpy as np
from playwright.sync_api import expect

from robots.kit.description import load
from tests.e2e.frames import read

KEPT_UP = {"ping", "here", "watch"}  # that a page lives, that its person is there, which pictures its line allows
AT_THE_ARM = "The ghost is at the arm"
KEYS = (("ArrowUp", "ArrowDown"), ("ArrowLeft", "ArrowRight"), ("PageUp", "PageDown"))  # of x, y, z: more and less
PLACE = re.compile(r"x, y, z (−?-?\d+), (−?-?\d+), (−?-?\d+) mm")
MOVED_M = 0.005  # a brick lies 1 mm beside its place in the description at first
TRIAL = 25  # px of a pull that shows where a handle leads
FARTHEST, TRIES = 400, 4  # px of one pull; how often it is corrected
LOOK_MS = 250  # until the list has followed
VIEWS = {"Side": (0, 2), "Top": (0, 1)}  # the axes that lie across each
SCALES = {"1": 6.0, "5": 3.0}  # of the hand's motion to the ghost's, and how near it is to come (mm)


def place(page):
    """Return where the ghost is (mm), as the list in words says."""
    numbers = PLACE.search(page.locator("#ghost-list").text_content()).groups()
    return np.array([float(text.replace("−", "-")) for text in numbers])


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


class Mouse:
    """Pulls the ghost's handles by mouse."""

    def __init__(self, person):
        self.person, self.page = person, person.page

    def go(self, target):
        """Bring the ghost to a place (mm), by one handle after another."""
        for scale, near in SCALES.items():
            self.page.select_option("#ghost-scale", scale)
            for view, axes in VIEWS.items():
                if self._off(target)[list(axes)].max() <= near:
                    continue
                self.page.locator("#viewpoints button", has_text=view).first.click()
                self.page.wait_for_timeout(LOOK_MS)
                for x, y in self._handles():
                    self._pull(x, y, np.array(target, float))
                    if self._off(target)[list(axes)].max() <= near:
                        break
        assert self._off(target).max() <= near, f"not {target}: {self.page.inner_text('#ghost-list')}"

    def _off(self, target):
        return np.abs(place(self.page) - target)

    def _handles(self):
        """Yield points in the view at which a pointer takes a handle, far from each other; where they are now."""
        canvas = self.page.locator("#model canvas")
        canvas.scroll_into_view_if_needed()
        box = canvas.bounding_box()
        tried = []
        for share_y in range(6, 96, 3):
            for share_x in range(6, 96, 3):
                x, y = box["x"] + box["width"] * share_x / 100, box["y"] + box["height"] * share_y / 100
                if any(np.hypot(x - u, y - v) < TRIAL for u, v in tried):
                    continue
                self.page.mouse.move(x, y)
                if self.page.evaluate("document.querySelector('#model canvas').style.cursor") == "grab":
                    tried.append((x, y))
                    yield x, y

    def _pull(self, x, y, target):
        """Take a handle, see where it leads, and pull it as near to the target as it goes."""
        begun, at = place(self.page), np.array([x, y])
        self.down(at)
        leads = []
        for way in ((TRIAL, 0), (0, TRIAL)):
            self.to(at + way)
            leads.append((place(self.page) - begun) / TRIAL)
        self.to(at)
        there, by = np.linalg.pinv(np.array(leads).T, rcond=0.2), np.zeros(2)
        for _ in range(TRIES):
            if np.abs(more := there @ (target - place(self.page))).max() <= 1:
                break
            by = np.clip(by + more, -FARTHEST, FARTHEST)
            self.to(at + by)
        self.up(at + by)
        self.page.wait_for_timeout(LOOK_MS)

    def to(self, point):
        self.move(point)
        self.page.wait_for_timeout(LOOK_MS)

    def down(self, point):
        self.page.mouse.move(*point)
        self.page.mouse.down()

    def move(self, point):
        self.page.mouse.move(*point, steps=4)

    def up(self, point):
        self.page.mouse.up()


class Fingers(Mouse):
    """Pulls them by a finger."""

    def __init__(self, person):
        super().__init__(person)
        self._wire = person.context.new_cdp_session(person.page)

    def _touch(self, what, *points):
        touches = [{"x": float(x), "y": float(y)} for x, y in points]
        self._wire.send("Input.dispatchTouchEvent", {"type": what, "touchPoints": touches})

    def down(self, point):
        self._touch("touchStart", point)

    def move(self, point):
        self._touch("touchMove", point)

    def up(self, point):
        self._touch("touchEnd")
