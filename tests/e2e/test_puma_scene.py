"""The PUMA 560 in its scene, in a browser: the rod by keyboard, mouse, touch and task."""

import numpy as np
import pytest
from playwright.sync_api import expect

from tests.e2e.ghost import KEYS, Fingers, Mouse, place

pytestmark = [pytest.mark.timed, pytest.mark.parametrize("which", ["puma"], indirect=True)]

WIDE = {"viewport": {"width": 1440, "height": 900}}
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
ABOVE, AT, LIFTED = (550, 300, 400), (550, 300, 300), (550, 300, 345)  # mm, of the tool beside the rod
LIFTED_M = 0.33
PRESSES = 10


@pytest.fixture
def operator(visitor):
    def make(**options):
        person = visitor(**options)
        person.cleared("ada").take_turn()
        expect(person.page.locator("#model canvas")).to_be_visible(timeout=30_000)
        expect(person.page.locator("#model-said")).to_have_text("The ghost is at the arm", timeout=30_000)
        return person

    return make


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
