"""The stop: holds the hardware and latches on disk; the row follows."""

import contextlib
import logging
import threading
from datetime import datetime, timedelta

from django.db.models import BigAutoField

from robots import bus
from robots.grants import rests_within
from robots.kit.contract.errors import RobotError
from robots.kit.contract.session import RobotState
from robots.kit.packets import Changed
from robots.models import Robot
from robots.prepared import Prepared, Slot
from robots.services.incidents import incident
from robots.services.stopping import NEWEST
from workers.authority.memory import StopLatch
from workers.robot.owned import OwnedRobot

log = logging.getLogger(__name__)
ROBOT = Slot("robot", BigAutoField())
_ROW: Prepared[Robot] = Prepared(
    lambda: Robot.objects.filter(pk=ROBOT).only("stop_latched", "releases", "stop_confirmed", "rests_by")
)


class Stop:
    """Stops one robot, and keeps latch and row the same."""

    def __init__(self, owned: OwnedRobot, latch: StopLatch) -> None:
        self._owned, self._latch = owned, latch
        self._halting = owned.clock.lock()
        self._releases: int | None = None  # number of releases in the row when it was last read
        self._at_rest = False  # the robot confirmed the hold of the latched stop
        self._rests_by: datetime | None = None  # the latest time of rest of an unconfirmed stop
        self._unasked_until = 0.0  # it may move until then (monotonic, s) by what an earlier owner allowed
        self._heard: RobotState | None = None  # the newest state when the hold was not confirmed
        self._trouble = ""  # an unconfirmed stop that is not yet stored as an incident
        self.due = threading.Event()  # the row alone says that the robot is stopped; `_due_releases` are the row's
        self._due_releases = 0

    def begin(self) -> None:
        """Latch if the row says that the robot is stopped; before anything is connected that could move.

        `follow` holds the robot once it is connected; if it cannot be, the row says by when it rests, because nothing
        was sent to it after the lease of the owner before. Raises Robot.DoesNotExist.
        """
        row, latch, robot = self._row(), self._latch, self._owned.robot
        self._releases = row.releases
        self._unasked_until = self._owned.clock.monotonic() + (rests_within(robot, robot.settings) or 0.0)
        if row.stop_latched and not latch.latched:
            latch.forbid(row.releases)
            latch.keep()
        if latch.latched:
            self._rests_by = row.rests_by if row.stop_latched and row.rests_by else self._latest()

    def _latest(self) -> datetime | None:
        """Return by when the robot rests to which nothing more is sent; None if its spec does not tell."""
        owned = self._owned
        seconds = owned.robot.spec().rest_s
        if seconds is None:
            return None
        with contextlib.suppress(RobotError):
            seconds = max(seconds, owned.driver.rests_within() or 0.0)
        if owned.driver.latest() is None:
            seconds = max(seconds, self._unasked_until - owned.clock.monotonic())
        return owned.now() + timedelta(seconds=seconds)

    def _row(self) -> Robot:
        row = _ROW.first(robot=self._owned.robot.pk)
        if row is None:
            raise Robot.DoesNotExist
        return row

    def note(self) -> None:
        """Write a latched stop into the row, unless it is there or was released; the latch stays as it is.

        Also called before a command ends: its job would otherwise look as if the robot had failed, and begin again.
        Raises the errors of the database.
        """
        latch, robot = self._latch, self._owned.robot
        if not latch.latched or not latch.row_pending:
            return
        row = Robot.objects.filter(pk=robot.pk, stop_latched=False)
        if latch.releases is not None:  # in the statement, so that a release at this moment is not undone
            row = row.filter(releases__lte=latch.releases)
        now, at_rest, rests_by = self._owned.now(), self._at_rest, self._rests_by
        if row.update(
            stop_latched=True, stopped_at=now, stopped_after=NEWEST, stop_confirmed=at_rest, rests_by=rests_by
        ):
            bus.publish(robot.slug, Changed("stop"))

    def halt(self, source: str, releases: int | None = None) -> None:
        """Hold the hardware and latch on disk. Queries neither Redis nor the database.

        `releases`: how many there had been by the stop; None: as many as are known.
        """
        latch = self._latch
        releases = self._releases if releases is None else releases  # as of the press, not of the end of a hold
        with self._halting:
            if latch.latched and self._at_rest:  # pressed twice; a late press must not undo a release
                if releases is not None and latch.releases is not None and releases > latch.releases:
                    latch.forbid(releases)  # the release that waits for this hold was before the press
                return
            first = not latch.latched
            latch.forbid(releases)
            try:
                kept = self._owned.clock.spawn(latch.keep, "latch")  # a slow disk must not delay the hold
            except RuntimeError:  # the system has no thread left
                self._hold()
                latch.keep()
            else:
                self._hold()
                kept.join()
        if first:
            log.info("stopped by %s", source)
            bus.publish(self._owned.robot.slug, Changed("stop"))

    def _hold(self) -> None:
        """Hold the hardware, and note whether it confirmed or by when it rests without another word."""
        owned = self._owned
        try:
            self._at_rest = not owned.driver.hold().moving
        except RobotError as error:
            self._at_rest = False
            log.error("a stop could not be confirmed: %s", error)
            self._trouble = f"A stop could not be confirmed: {error}"
        if self._at_rest:
            self._rests_by = None
            return
        self._rests_by = self._rests_by or self._latest()  # by the first hold that failed: nothing was begun since
        self._heard = owned.driver.latest()

    def hold_due(self) -> None:
        """Hold where the row alone says that the robot is stopped, or once more where a stop was not confirmed.

        A hold may take seconds, for which nobody who reads rows may wait: a stop that is pressed later than a release
        could not be told from one before it.
        """
        if self.due.is_set():
            self.due.clear()
            self.halt("row", self._due_releases)
        if not self._latch.latched or self._at_rest or self._owned.driver.latest() in (None, self._heard):
            return
        with self._halting:
            if self._latch.latched and not self._at_rest:
                self._hold()

    def _tell(self, confirmed: bool, rests_by: datetime | None) -> None:
        """Write into the row, which says this, whether the stop is confirmed."""
        if not self._latch.latched or (confirmed, rests_by) == (self._at_rest, self._rests_by):
            return
        robot = self._owned.robot
        Robot.objects.filter(pk=robot.pk).update(stop_confirmed=self._at_rest, rests_by=self._rests_by)
        bus.publish(robot.slug, Changed("stop"))

    def _unwritten(self, releases: int) -> bool:
        """Return whether the row, with so many releases, has still to be told of the latched stop."""
        latch = self._latch
        return latch.row_pending and (latch.releases is None or releases <= latch.releases)

    def _release(self, releases: int) -> None:
        """Undo the latch by a row with so many releases; not if somebody pressed while this waited for a hold."""
        with self._halting:
            if self._unwritten(releases):
                return
            self._latch.release()
            self._at_rest, self._rests_by, self._heard = False, None, None
        bus.publish(self._owned.robot.slug, Changed("stop"))

    def follow(self) -> None:
        """Compare latch and row once: the robot is latched if either says so, until a release undoes both."""
        robot, latch = self._owned.robot, self._latch
        if self._trouble:
            incident(robot, "stop_failed", self._trouble, self._owned.now())
            self._trouble = ""
        row = self._row()
        in_row, releases, confirmed, rests_by = row.stop_latched, row.releases, row.stop_confirmed, row.rests_by
        self._releases = releases
        if in_row and not latch.latched:
            self._due_releases = releases
            self.due.set()
        elif in_row:
            latch.row_pending = False
        elif latch.latched and self._unwritten(releases):
            self.note()
            latch.row_pending = False
        elif latch.latched:
            self._release(releases)
        self._tell(confirmed, rests_by)
