"""The loop that holds motions that are no longer allowed, and reports that the owner lives.

It asks neither Redis nor the database nor the disk, so none can delay it; it judges from memory, which other loops
write, and holds before it writes a line to the log.
"""

import contextlib
import logging
import sys
from collections.abc import Callable
from pathlib import Path

from robots.kit.brownout import Brownout
from robots.kit.contract.errors import RobotError
from workers.authority.lane import MOTION, Lane
from workers.guard.deadman import DeadManTimer
from workers.robot.owned import OwnedRobot

log = logging.getLogger(__name__)
WATCH_S, IDLE_WATCH_S = 0.05, 0.25
TOUCH_S = 0.5  # of the file by which the supervisor sees that the owner lives


class Heartbeat:
    """Touches the file of the supervisor in a thread of its own while `beat` is called again and again.

    So a disk that stalls does not delay the watch, which holds the robot.
    """

    def __init__(self, owned: OwnedRobot, file: Path) -> None:
        self._owned, self._file = owned, file
        self._beats = 0

    def beat(self) -> None:
        """Note that the watch goes round and every lane is sound."""
        self._beats += 1

    def loop(self) -> None:
        """Touch the file for the beats of the last while, until the owner ends."""
        told = 0
        while self._owned.running:
            if (beats := self._beats) != told:
                with contextlib.suppress(OSError):
                    self._file.touch()
                told = beats
            self._owned.clock.sleep(TOUCH_S)


class Watch:
    """Holds the robot if lease, link, grant or an operator's keep-alives are missing."""

    def __init__(
        self, owned: OwnedRobot, lanes: tuple[Lane, ...], deadman: DeadManTimer,
        brownout: Brownout, heartbeat: Heartbeat, on_lost: Callable[[], None],
    ) -> None:  # fmt: skip
        self._owned, self._lanes, self._deadman = owned, lanes, deadman
        self._lease, self._pace = lanes[0].lease, lanes[0].pace
        self._brownout, self._heartbeat, self._on_lost = brownout, heartbeat, on_lost
        self._held: dict[str, int] = {}  # by lane: the command that was held last

    def loop(self) -> None:
        """Watch until the owner ends."""
        owned, clock, ours = self._owned, self._owned.clock, True
        while owned.running:
            if self._lease.lost:
                self.leave("its lease is lost to another owner")
                return
            valid = self._lease.valid
            if ours and not valid:  # in any case: no heartbeat may say that the robot is ours
                with contextlib.suppress(RobotError, OSError):
                    owned.driver.hold()
                log.warning("the lease of %s ran out: it was told to hold", owned.robot.slug)
            ours = valid
            for lane in self._lanes:
                self._hold_what_is_forbidden(lane)
            if all(lane.sound for lane in self._lanes):
                self._heartbeat.beat()
            begun = clock.monotonic()
            meant = self._pace.sleep(WATCH_S, IDLE_WATCH_S)
            woken = clock.monotonic()
            self._brownout.feel(woken - begun - meant, woken)

    def _hold_what_is_forbidden(self, lane: Lane) -> None:
        """Hold for a lane's forbidden command, and for a motion without a command; only the lane `motion` moves."""
        state, command, motion = self._owned.driver.latest(), lane.current, lane.name == MOTION
        running = command is not None and command.pk != self._held.get(lane.name)
        moving = motion and state is not None and state.moving
        if moving or lane.busy or lane.gate.authority.latch.latched:
            self._pace.stir()
        if (lane.gate.forbidden or (motion and self._deadman.end_reason)) and (running or moving):
            if command is not None:
                self._held[lane.name] = command.pk
            with contextlib.suppress(RobotError):
                self._owned.driver.hold()

    def leave(self, why: str) -> None:
        """Hold the robot and end this process, whatever its driver raises; log why, and the error that is handled now.

        Another owner takes the robot, or the supervisor starts one.
        """
        owned = self._owned
        owned.running = False
        try:
            owned.driver.hold()
        except Exception:
            log.exception("the robot could not be held")
        finally:
            log.error("the owner of %s holds it and ends: %s", owned.robot.slug, why, exc_info=sys.exception())
            try:
                owned.driver.close()
            except Exception:
                log.exception("the line could not be closed")
            finally:
                self._on_lost()
