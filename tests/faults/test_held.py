"""Held motion against the real worker: steps while keep-alives arrive, rest soon after they end."""

import threading
import time

import pytest

from robots import bus
from robots.models import Command
from tests.conftest import EACH_AT_LENGTH, wait_for

pytestmark = pytest.mark.alone  # it judges by fractions of a second


class Holding(threading.Thread):
    """Keep-alives as the console sends them, until told to stop."""

    def __init__(self, user, seq, slug="mercury"):
        super().__init__(daemon=True)
        self.slug = slug
        self.user, self.seq, self.on = user, seq, True
        self.last = 0.0
        self.start()

    def run(self):
        while self.on:
            self.last = time.monotonic()
            bus.send_keep_alive(self.slug, self.user, self.seq, True)
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


def test_a_jog_goes_on_while_held_and_ends_when_released(rig):
    rig.owner()
    rig.grant()
    x = rig.sim.status()["pose"][0]
    command = rig.issue("jog", dx=1, dy=0)
    controls = Holding(rig.people["ada"].pk, command.client_seq)
    wait_for(lambda: rig.sim.status()["pose"][0] > x + 0.03, 10, "several steps")
    assert Command.objects.get(pk=command.pk).state == "acknowledged"
    controls.drop()
    at = time.monotonic()
    bus.send_keep_alive("mercury", rig.people["ada"].pk, command.client_seq, False)
    assert rest_after(rig, at, command) < 0.5
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
        controls = Holding(rig.people["ada"].pk, command.client_seq, rig.robot.slug)
        rig.moving()
        time.sleep(0.2 + 0.07 * (i % 5))
        controls.drop()
        seconds = rest_after(rig, controls.last, command)
        if witness.clean(controls.last, controls.last + seconds):
            took.append(seconds)
        assert command.state == "cancelled"
        assert "Nothing was heard" in command.reason
    assert len(took) == 5, "the machine stalled too often to tell"
    assert max(took) < 0.5, took


@pytest.mark.length
def test_nobody_elses_keep_alives_count(rig):
    rig.owner()
    rig.grant()
    command = rig.issue("jog", dx=1, dy=0)
    controls = Holding(rig.people["bob"].pk, command.client_seq)
    try:
        assert rig.final(command, 5).state == "cancelled"
    finally:
        controls.drop()


@pytest.mark.length
def test_a_jog_stays_on_the_sand(rig):
    rig.owner()
    rig.grant()
    rig.final(rig.issue("move", x=0.23, y=0.5))
    command = rig.issue("jog", dx=1, dy=0)
    controls = Holding(rig.people["ada"].pk, command.client_seq)
    try:
        command = rig.final(command, 10)
    finally:
        controls.drop()
    assert (command.state, command.result["ended"]) == ("completed", "edge")
    assert max(r["target"][0] for r in rig.sim.journal() if r["event"] == "motion") <= 0.2401


@pytest.mark.length
def test_a_stop_ends_a_jog_and_is_its_reason(rig):
    rig.owner()
    rig.grant()
    command = rig.issue("jog", dx=-1, dy=0)
    controls = Holding(rig.people["ada"].pk, command.client_seq)
    rig.moving()
    bus.send_stop("mercury")
    try:
        command = rig.final(command, 5)
    finally:
        controls.drop()
    assert (command.state, command.reason) == ("cancelled", "The robot is stopped.")
