"""Held motion against the real worker: steps while keep-alives arrive, rest soon after they end."""

import threading
import time

import pytest

from robots import bus
from robots.models import Command
from robots.states import COMMAND_FINAL
from tests.conftest import EACH_AT_LENGTH, wait_for
from tests.faults.controls import LOST
from tests.faults.test_promises_stop import release

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed


class Holding(threading.Thread):
    """Keep-alives as the console sends them, until told to stop."""

    def __init__(self, command, slug="mercury"):
        super().__init__(daemon=True)
        self.slug = slug
        self.command, self.on = command, True
        self.last = 0.0
        self.start()

    def run(self):
        while self.on:
            self.last = time.monotonic()
            bus.send_keep_alive(self.slug, self.command, True)
            time.sleep(0.08)

    def drop(self):
        self.on = False
        self.join()


def rest_after(rig, at, command):
    """Return how long after `at` the set-point came to rest for good (s): the motion is over, and no other waits."""
    rig.final(command)
    rig.swept()
    assert not rig.sim.status()["moving"]
    return max(r["t"] for r in rig.sim.journal() if r["event"] == "rest") - at


def attempts(witness, what):
    """Yield what tells whether the machine ran well since; a stall of a quarter of a second ends a held motion."""
    for _ in range(10):
        begun = time.monotonic()
        yield lambda begun=begun: witness.clean(begun, time.monotonic())
    raise AssertionError(f"{what}: not within ten attempts, because the machine stalled too often")


def test_a_jog_goes_on_while_held_and_ends_when_released(rig, witness):
    rig.owner()
    rig.grant()
    direction = 1
    for clean in attempts(witness, "a jog that is released"):
        x = rig.sim.status()["pose"][0]
        command = rig.issue("jog", dx=direction, dy=0)
        controls = Holding(command.pk)

        def state(command=command):
            return Command.objects.get(pk=command.pk).state

        def stepped(x=x, direction=direction):
            return direction * (rig.sim.status()["pose"][0] - x) > 0.03

        wait_for(lambda: stepped() or state() in COMMAND_FINAL, 10, "several steps")
        before = state()
        at = time.monotonic()
        bus.send_keep_alive("mercury", command.pk, False)
        controls.drop()
        seconds = rest_after(rig, at, command)
        if clean():
            break
        direction = -direction
    assert before == "acknowledged"
    assert stepped()
    assert seconds < 0.5
    assert (command.state, command.result["ended"]) == ("completed", "released")
    assert command.result["still"]


@EACH_AT_LENGTH
def test_lost_controls_hold_within_half_a_second_and_says_so(rig, witness):
    rig.owner()
    rig.grant()
    took = []
    for i in range(20):
        if len(took) == 5:
            break
        kind, args = rig.wishes.jog((-1) ** i)
        command = rig.issue(kind, **args)
        controls = Holding(command.pk, rig.robot.slug)
        rig.moving()
        time.sleep(0.2 + 0.07 * (i % 5))
        controls.drop()
        seconds = rest_after(rig, controls.last, command)
        if seconds > 0 and witness.clean(controls.last, controls.last + seconds):  # else a stall had ended it before
            took.append(seconds)
        assert command.state == "cancelled"
        assert LOST in command.reason
    assert len(took) == 5, "five measurements: not within 20 attempts, because the machine stalled too often"
    assert max(took) < 0.5, took


def test_a_jog_stays_on_the_sand(rig, witness):
    rig.owner()
    rig.grant()
    for clean in attempts(witness, "a jog to the edge"):
        rig.final(rig.issue("move", x=0.23, y=0.5))
        command = rig.issue("jog", dx=1, dy=0)
        controls = Holding(command.pk)
        try:
            command = rig.final(command, 10)
        finally:
            controls.drop()
        if LOST not in command.reason or clean():
            break
    assert (command.state, command.result["ended"]) == ("completed", "edge")
    assert max(r["target"][0] for r in rig.sim.journal() if r["event"] == "motion") <= 0.2401


def test_a_stop_ends_a_jog_and_is_its_reason(rig, witness):
    rig.owner()
    rig.grant()
    for clean in attempts(witness, "a jog that is stopped"):
        command = rig.issue("jog", dx=-1, dy=0)
        controls = Holding(command.pk)
        try:
            rig.moving()
            wait_for(lambda: bus.send_stop("mercury"), 5, "Redis takes the stop")
            command = rig.final(command, 5)
        finally:
            controls.drop()
        if LOST not in command.reason or clean():
            break
        release(rig)
    assert (command.state, command.reason) == ("cancelled", "The robot is stopped.")
