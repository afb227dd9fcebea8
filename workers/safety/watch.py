"""The loop that holds what may no longer move, and feeds the heartbeat.

It asks no store: a database that stalls or a Redis that is gone cannot keep it waiting.
What it judges by is memory, written by the loops that do ask.
"""

import contextlib
import logging
from collections.abc import Callable
from pathlib import Path

from robots.brownout import Brownout
from robots.drivers.errors import RobotError
from workers.owned import OwnedRobot
from workers.safety.deadman import DeadManTimer
from workers.safety.lane import MOTION, Lane
from workers.safety.lease import OwnerLease
from workers.safety.pace import Pace

log = logging.getLogger(__name__)
WATCH_S, IDLE_WATCH_S = 0.05, 0.25


class Watch:
    """Holds the robot without a lease, a link, a grant or an operator's keep-alives."""

    def __init__(
        self, owned: OwnedRobot, lease: OwnerLease, lanes: tuple[Lane, ...], deadman: DeadManTimer,
        pace: Pace, brownout: Brownout, heartbeat: Path, on_lost: Callable[[], None],
    ) -> None:  # fmt: skip
        self._owned, self._lease, self._lanes, self._deadman = owned, lease, lanes, deadman
        self._pace, self._brownout, self._heartbeat, self._on_lost = pace, brownout, heartbeat, on_lost
        self._held: dict[str, int] = {}  # the command of each lane that was held last

    def loop(self) -> None:
        """Watch for as long as the owner runs."""
        owned, clock, ours = self._owned, self._owned.clock, True
        while owned.running:
            if self._lease.lost:
                self.leave("its lease is lost to another owner")
                return
            valid = self._lease.valid
            if ours and not valid:  # whatever the robot does: nobody may be told that it is ours
                log.warning("the lease of %s ran out: holding", owned.robot.slug)
                with contextlib.suppress(RobotError, OSError):
                    owned.driver.hold()
            ours = valid
            for lane in self._lanes:
                self._hold_what_is_forbidden(lane)
            if all(lane.sound for lane in self._lanes):
                with contextlib.suppress(OSError):
                    self._heartbeat.touch()
            begun = clock.monotonic()
            meant = self._pace.sleep(WATCH_S, IDLE_WATCH_S)
            woken = clock.monotonic()
            self._brownout.feel(woken - begun - meant, woken)

    def _hold_what_is_forbidden(self, lane: Lane) -> None:
        """Hold for a lane's command, and where it moves nobody knows why: motion is a matter of its lane alone."""
        state, command, motion = self._owned.driver.latest(), lane.current, lane.name == MOTION
        running = command is not None and command.pk != self._held.get(lane.name)
        moving = motion and state is not None and state.moving
        if moving or lane.busy or lane.gate.latch.latched:
            self._pace.stir()
        if (lane.gate.forbidden or (motion and self._deadman.ended)) and (running or moving):
            if command is not None:
                self._held[lane.name] = command.pk
            with contextlib.suppress(RobotError):
                self._owned.driver.hold()

    def leave(self, why: str) -> None:
        """Hold the robot and end this process; another owner takes it, or the supervisor starts one."""
        owned = self._owned
        log.error("the owner of %s holds it and ends: %s", owned.robot.slug, why)
        owned.running = False
        with contextlib.suppress(RobotError, OSError):
            owned.driver.hold()
        owned.driver.close()
        self._on_lost()
