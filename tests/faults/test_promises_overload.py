"""Promise 43: on an overloaded machine only pictures become slower."""

import json
import subprocess
import sys
import time

import pytest
from django.conf import settings

from portal.run.supervisor import HEARTBEAT_S
from robots.kit.contract.errors import NotPermitted
from robots.models import Command, Robot
from robots.states import COMMAND_FINAL
from tests.conftest import BOTH_AT_LENGTH, wait_for
from tests.faults.test_promises_stop import held_after, socket_of
from tests.faults.viewer import Watching
from tests.rig import Web, housekeeping

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

BUSY = 20
BACK_S = 15.0
WINDOW_S = 3.0  # over which pictures are counted
ENOUGH = 0.75  # of the usual pictures: one more or less falls into a window
NOT_BEGUN = ("rejected", "expired")


class BusyProcesses:
    """Processes at our own nice level that want all there is."""

    def __enter__(self):
        self._all = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(BUSY)]

    def __exit__(self, *_):
        for one in self._all:
            one.kill()
        for one in self._all:
            one.wait()


class Day:
    """One operator's moves and stops, each move to a place of its own."""

    def __init__(self, rig, operator, witness):
        self.rig, self.operator, self.witness = rig, operator, witness
        self.moves, self.stops, self.stalled, self.beats = [], [], [], []
        self._heartbeat = settings.VAR / "run" / f"{rig.robot.slug}.heartbeat"

    def beat(self):
        self.beats.append(time.time() - self._heartbeat.stat().st_mtime)

    def move(self):
        number = len(self.moves)
        side = -1 if number % 2 else 1
        try:
            command = self.rig.issue("move", x=side * (0.1 + number % 50 / 1000), y=0.35 + number // 50 / 1000)
        except NotPermitted as refused:  # the owner has not got the robot again yet
            time.sleep(0.3)
            return str(refused)
        self.moves.append(command)
        return command

    def settle(self, command, seconds=60):
        def ended():
            self.beat()
            command.refresh_from_db()
            return command.state in COMMAND_FINAL

        wait_for(ended, seconds, f"the end of {command}")

    def stop(self):
        """Press Stop in mid-motion, on the page's socket; judge by the simulator's log."""
        command = self.move()
        if isinstance(command, str):
            return
        before = self.rig.sim.count("motion")
        until = time.monotonic() + 15
        while self.rig.sim.count("motion") == before and time.monotonic() < until:
            command.refresh_from_db()
            if command.state in COMMAND_FINAL:
                return  # it never began, so there is nothing to stop
            time.sleep(0.02)
        at = time.monotonic()
        self.operator.send(json.dumps({"t": "stop"}))
        seconds = held_after(self.rig, at)
        (self.stops if self.witness.clean(at, at + seconds) else self.stalled).append(seconds)
        self.settle(command)
        wait_for(lambda: Robot.objects.get().stop_latched, 15, "the row follows")
        # as the page does, after the row of its stop: another way could overtake that on a busy machine
        self.operator.send(json.dumps({"t": "release", "checked": True}))
        wait_for(lambda: not (settings.VAR / "run" / f"{self.rig.robot.slug}.stopped").exists(), 15, "the release")

    def goes_on(self, passed, seconds):
        """Tell whether to go on: for so long, and until a stop was judged; a command may expire before it moves."""
        return passed < seconds or (not self.stops + self.stalled and passed < 10 * seconds)

    def untrue(self):
        """Return the commands whose row says something else than the robot's own log."""
        wrong = []
        for command in self.moves:
            command.refresh_from_db()
            made = len(self.rig.motions(command))
            begun = command.sent_at is not None or command.state == "completed"
            if made > 1 or (command.state == "completed" and made != 1) or (made and command.state in NOT_BEGUN):
                wrong.append((command.pk, command.state, command.reason, made))
            elif made and not begun and command.state != "unknown":
                wrong.append((command.pk, command.state, "moved, and the row knows of no sending", made))
        return wrong


@BOTH_AT_LENGTH
def test_promise_43_overload_is_a_brownout(rig, proof, witness):
    seconds = proof.count(f"seconds beside {BUSY} busy processes", 10, 300)
    owner, housekeeper, web = rig.owner(), housekeeping(), Web()
    epoch = rig.lease().epoch
    try:
        rig.grant(seconds=3000)
        rig.slow()
        with socket_of(web, rig.people["ada"]) as operator:
            watching = Watching(operator)
            day = Day(rig, operator, witness)
            time.sleep(3.0 + WINDOW_S)
            usual = watching.rate(WINDOW_S)
            with BusyProcesses():
                since = time.monotonic()
                while day.goes_on(time.monotonic() - since, seconds):
                    day.stop()
                    last = day.move()
                    if isinstance(last, Command):
                        day.settle(last)
                busy = sum(at > since for at in watching.pictures) / (time.monotonic() - since)
            back = as_before(day, watching, usual)
        assert day.untrue() == []
        assert owner.alive() and housekeeper.alive() and web.alive()
        assert rig.lease().pid == owner.pid
        assert max(day.beats) < HEARTBEAT_S, "the supervisor would have killed it"
        assert day.stops or day.stalled, [(str(c), c.state, c.reason) for c in day.moves]
        assert max(day.stops + day.stalled) <= 1.0, (day.stops, day.stalled)
    finally:
        web.kill()
        housekeeper.kill()
    stops, again = day.stops + day.stalled, rig.lease().epoch - epoch
    proof.holds(
        f"{seconds} s beside {BUSY} busy processes: 0 owners restarted, lease taken again {again} times, {len(day.moves)} "
        f"commands without an untrue word, {len(stops)} stops at rest within {max(stops) * 1000:.0f} ms; {usual:.1f} "
        f"pictures a second fell to {busy:.1f}; as before after {back:.1f} s"
    )


def as_before(day, watching, usual):
    """Wait until a command completes and pictures come as usual; return after how many seconds."""
    # an arm told its speed at each command: at a twentieth it is on its way for longer than this waits
    day.rig.share = 0.5
    since, ends = time.monotonic(), []

    def works():
        command = day.move()
        if isinstance(command, Command):
            day.settle(command, BACK_S)
        ends.append(f"{command}: {getattr(command, 'reason', '')}")
        return isinstance(command, Command) and command.state == "completed"

    while not works():
        assert time.monotonic() < since + BACK_S, f"no command completes: not within {BACK_S} s, {ends}"
    left = since + BACK_S - time.monotonic()
    wait_for(lambda: watching.rate(WINDOW_S) >= ENOUGH * usual, left, f"{usual:.1f} pictures a second")
    return time.monotonic() - since
