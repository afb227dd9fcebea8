"""Driving by hand toward a wall of the simulated hall: what is near is felt, and the rover rests before it touches."""

import threading
import time
from math import dist

import pytest
from playwright.sync_api import expect

from robots.kit.description import load
from robots.kit.drivers.srv1.hall import hall
from tests.conftest import wait_for
from tests.e2e.test_rover_stick import PAD, PHONE, middle

# ruff: noqa: TID251 - its tests are timed
pytestmark = [pytest.mark.timed, pytest.mark.parametrize("which", ["srv1"], indirect=True)]

PLACE = 586  # of those where the fault board sets the rover down: west of it, 3 m away, is nothing but a wall
NOSE_M = 0.14  # from the middle of the rover
FAR_M, NEAR_M, THERE_M = 1.8, 0.5, 0.3  # beyond the first nothing is felt
REFLEX_M = load("srv1")["sonar"]["stop"] + 0.04  # nearer, but for its noise, it does not drive ahead
WAY_S = 180  # a way of 7 s, where the machine is busy
BUZZED = """
window.buzzed = [];
navigator.vibrate = (ms) => { window.buzzed.push({ ms, at: Date.now() }); return true; };
"""


class Truth(threading.Thread):
    """What the simulator says, ten times a second: when (ms since 1970), metres to what is ahead, and the speed (m/s)."""

    def __init__(self, sim):
        super().__init__(daemon=True)
        self._sim, self._over = sim, threading.Event()
        self.samples, self.touched = [], set()
        self.start()

    def run(self):
        before = None
        while not self._over.wait(0.1):
            status = self._sim.status()
            now, (x, y, heading) = time.time(), status["pose"]
            self.touched |= set(status["contacts"])
            speed = dist(before[1], (x, y)) / (now - before[0]) if before else 0.0
            before = now, (x, y)
            self.samples.append((1000 * now, hall().ray(x, y, heading)[0] - NOSE_M, speed))

    def left_at(self, ms):
        """Return how far it was to what is ahead, then."""
        return min(self.samples, key=lambda sample: abs(sample[0] - ms))[1]

    def at_rest(self, near=True):
        """Tell whether it rests for half a second; `near`: where the reflex holds it."""
        newest = self.samples[-6:]
        return len(newest) == 6 and all(speed < 0.01 and (not near or left < REFLEX_M) for _, left, speed in newest)

    def stop(self):
        self._over.set()
        self.join()


@pytest.fixture
def truth(portal):
    made = Truth(portal.sim)
    yield made
    made.stop()


@pytest.fixture
def operator(portal, visitor, truth):
    """Return a function that makes a person who drives, before a wall."""

    def make(**options):
        one = visitor(**options)
        one.page.context.add_init_script(PAD + BUZZED)
        one.cleared("ada")
        one.take_turn()
        expect(one.page.locator(".stick")).to_have_attribute("aria-disabled", "false", timeout=30_000)
        wait_for(lambda: truth.at_rest(near=False), 20, "it rests")
        portal.sim.fault("carried", PLACE)
        wait_for(lambda: truth.samples[-1][1] == pytest.approx(2.82, abs=0.02), 10, "it stands before a wall")
        truth.touched.clear()
        truth.samples.clear()
        one.page.locator(".stick").scroll_into_view_if_needed()
        one.page.wait_for_timeout(200)  # a gamepad is seen at rest
        one.page.evaluate("window.buzzed.length = 0")  # somebody's turn began
        return one

    return make


def grows(felt, truth):
    """Check by the truth what was felt (when, how strong): nothing far away, and the nearer, the more."""
    told = [(truth.left_at(at), level) for at, level in felt]
    assert all(left < FAR_M for left, _ in told), told
    early = [level for left, level in told if left > NEAR_M]
    late = [level for left, level in told if THERE_M < left <= NEAR_M]
    last = [level for left, level in told if left <= THERE_M]
    means = [sum(levels) / len(levels) for levels in (early, late, last) if levels]
    assert len(means) == 3, told
    assert means[0] < means[1] < means[2], means
    assert max(early) < max(last)


def push(page, ahead):
    page.evaluate("(y) => { window.pad.axes = [0, -y]; }", ahead)


def test_a_wall_is_felt_in_a_gamepad_and_the_rover_rests_before_it(portal, operator, truth):
    one = operator()
    page, stick = one.page, one.page.locator(".stick")

    def hold(ahead, far, what):
        one.hold_until(stick, lambda: push(page, ahead), lambda: push(page, 0), far, what, WAY_S)

    def let_go():
        push(page, 0)
        expect(stick).to_have_class("stick")

    def effects():
        return page.evaluate("window.shaken.map(({ at, strongMagnitude }) => [at, strongMagnitude])")

    hold(1, truth.at_rest, "it rests before the wall")
    assert max(speed for _, left, speed in truth.samples if left > NEAR_M) > 0.3
    assert not truth.touched
    grows(effects(), truth)
    assert effects()[-1][1] > 0.8
    assert page.evaluate("window.buzzed.length") == 0

    page.uncheck(".feel input")
    page.wait_for_timeout(300)
    count, until = len(effects()), time.monotonic() + 1.0
    hold(1, lambda: time.monotonic() > until, "it is held on")
    assert len(effects()) == count, "it can be switched off"
    page.check(".feel input")
    hold(1, lambda: len(effects()) > count, "and on again")
    let_go()
    count = len(effects())
    hold(-1, lambda: truth.samples[-1][2] > 0.2, "it drives back")
    assert len(effects()) == count, "who drives back feels nothing"
    let_go()
    wait_for(lambda: truth.at_rest(near=False), 10, "whoever lets go rests it")
    assert not truth.touched


def test_on_a_phone_the_stick_gives_way_and_it_vibrates(portal, operator, truth):
    one = operator(**PHONE)
    page, stick = one.page, one.page.locator(".stick")
    session, held = page.context.new_cdp_session(page), []

    def touch(kind, *points):
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y} for x, y in points]})

    def press():
        stick.scroll_into_view_if_needed()
        x, y, radius = middle(page)
        held.append((x, y - radius + 6))
        touch("touchStart", held[0])

    def release():
        if held:
            touch("touchEnd")
        held.clear()

    def pushed():
        return float(stick.locator(".stick-knob").evaluate("(knob) => -knob.style.getPropertyValue('--y')"))

    one.hold_until(
        stick, press, release, lambda: truth.samples[-1][1] < 2.5 and pushed() > 0.9, "nothing is felt", WAY_S
    )
    one.hold_until(stick, press, release, truth.at_rest, "it rests before the wall", WAY_S)
    assert pushed() < 0.6, "the finger is where it was"
    slow = [speed for _, left, speed in truth.samples if THERE_M < left < NEAR_M]
    assert min(slow) < 0.28, "so the speed falls"
    assert not truth.touched
    grows(page.evaluate("window.buzzed.map(({ at, ms }) => [at, ms])"), truth)
    assert page.evaluate("window.shaken.length") == 0

    page.uncheck(".feel input")
    one.hold_until(stick, press, release, lambda: pushed() > 0.9, "no resistance where it is switched off")
    release()
    expect(stick).to_have_class("stick")
    wait_for(lambda: pushed() == 0, 10, "it springs back")
