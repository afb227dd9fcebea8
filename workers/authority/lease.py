"""One owner per robot: a device lock on the machine, and a lease with an epoch in the database."""

import contextlib
import fcntl
import logging
import os
import threading
from collections.abc import Callable
from datetime import datetime, timedelta
from pathlib import Path

from django.conf import settings
from django.db import Error, close_old_connections, connection
from django.db.models import BigAutoField, BigIntegerField, DateTimeField

from robots.grants import take_epoch
from robots.kit.clock import SYSTEM, Clock
from robots.models import Lease, Robot
from robots.prepared import PreparedUpdate, Slot
from workers.authority.processes import Processes

log = logging.getLogger(__name__)
RENEW_S = 0.75  # three attempts within a lease of three seconds
ROBOT, EPOCH = Slot("robot", BigAutoField()), Slot("epoch", BigIntegerField())
PID, UNTIL = Slot("pid", BigIntegerField()), Slot("until", DateTimeField())
_RENEW = PreparedUpdate(lambda: Lease.objects.filter(robot=ROBOT, epoch=EPOCH, pid=PID), expires_at=UNTIL)


class DatabaseClock:
    """A clock whose `now` is the database's time, as far as the owner's lease has measured it."""

    def __init__(self, clock: Clock, now: Callable[[], datetime]) -> None:
        self.now = now
        self.monotonic, self.awake, self.sleep = clock.monotonic, clock.awake, clock.sleep
        self.wait, self.spawn, self.lock = clock.wait, clock.spawn, clock.lock


class OwnerLease:
    """The lease of one robot, which tells whether the robot is ours.

    If the lease lapses: hold, then take it again under a new epoch. If another has taken it: hold, and end.
    """

    def __init__(
        self, robot: Robot, lock_file: Path, clock: Clock = SYSTEM, processes: Processes | None = None
    ) -> None:
        self._robot, self._lock_file, self._clock = robot, lock_file, clock
        self._processes = processes or Processes()
        self.own = self._processes.own
        self._seconds = float(settings.FARHAND["LEASE_S"])
        self._descriptor: int | None = None
        self._until = 0.0
        self.epoch = 0
        self.offset = timedelta(0)  # the database's time minus ours
        self.lost = False
        self._measured = self._lapsed = False
        self._found: tuple[datetime | None, int] | None = None  # another's lease as it was found
        self._found_at = 0.0  # by `awake` (s): it may have slept with us
        self._lock = threading.Lock()

    @property
    def valid(self) -> bool:
        """Return whether we own the robot, by our own clock; a lapsed lease stays invalid until it is taken again."""
        with self._lock:
            self._lapsed = self._lapsed or self._clock.monotonic() >= self._until
            return not self.lost and not self._lapsed

    def acquire(self, give_up: Callable[[], bool]) -> bool:
        """Wait until the robot is ours. Return False if `give_up` said so."""
        Lease.objects.get_or_create(robot=self._robot)
        while not give_up():
            if self._try():
                log.info("owner of %s with epoch %s", self._robot.slug, self.epoch)
                return True
            self._clock.sleep(0.25)
        return False

    def _try(self) -> bool:
        self.measure_offset()
        lease = Lease.objects.get(robot=self._robot)
        if not self._over(lease):
            return False
        self._processes.kill_recorded_owner(lease)
        if not self._lock_device():
            return False
        return self._take(lease)

    def _over(self, lease: Lease) -> bool:
        """Return whether another's lease is over.

        The time of day may have been set since it was written. So an owner that may live is waited for by our own
        clock: it is gone if it has renewed nothing for a whole lease.
        """
        if lease.expires_at is None or (self._processes.owner_gone(lease) and lease.expires_at <= self.now()):
            return True
        if self._found != (found := (lease.expires_at, lease.epoch)):
            self._found, self._found_at = found, self._clock.awake()
        return self._clock.awake() - self._found_at > self._seconds

    def _take(self, lease: Lease) -> bool:
        begun, own = self._clock.monotonic(), self.own
        epoch = take_epoch(lease, self.now(), self._seconds, own.host, own.pid, own.started)
        if epoch is None:
            return False
        with self._lock:
            self.epoch, self._until, self._lapsed = epoch, begun + self._seconds, False
        return True

    def regain(self) -> bool:
        """Take a lapsed lease again under a new epoch. Return False if another has taken it; the lease is lost then.

        Called while no command runs. Raises django.db.Error while the database does not answer.
        """
        self.measure_offset()
        lease = Lease.objects.filter(robot=self._robot, epoch=self.epoch, pid=self.own.pid).first()
        if self.lost or lease is None or not self._take(lease):
            self.lost = True
            return False
        log.warning("the lease of %s ran out and was taken again, with epoch %s", self._robot.slug, self.epoch)
        return True

    def _lock_device(self) -> bool:
        if self._descriptor is None:
            self._lock_file.parent.mkdir(parents=True, exist_ok=True)
            self._descriptor = os.open(self._lock_file, os.O_RDWR | os.O_CREAT, 0o600)
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True

    def now(self) -> datetime:
        """Return the database's time, by the last measured offset."""
        return self._clock.now() + self.offset

    def measured_now(self) -> datetime:
        """Return the database's time, measured at this moment if the database answers."""
        with contextlib.suppress(Error):
            self.measure_offset()
        return self.now()

    def measure_offset(self) -> None:
        """Measure how far the database's clock is from ours."""
        if connection.vendor != "postgresql":
            self.offset = timedelta(0)  # SQLite uses this host's clock
            return
        before = self._clock.now()
        with connection.cursor() as cursor:
            cursor.execute("SELECT clock_timestamp()")
            (theirs,) = cursor.fetchone()
        self._learn(theirs - self._clock.now(), theirs - before)

    def _learn(self, least: timedelta, greatest: timedelta) -> None:
        """Use the offset if the measurement was quick; a slow one says little."""
        if not self._measured:
            self.offset, self._measured = least + (greatest - least) / 2, True
        self.offset = min(max(self.offset, least), greatest)

    def renew(self) -> None:
        """Renew once; mark the lease lost if another has taken it or it was given back.

        A renewal that succeeds after the lease ran out changes nothing, because permits have been refused by then.
        """
        if not self.valid and not self.lost:
            return
        self.measure_offset()
        begun, epoch = self._clock.monotonic(), self.epoch
        until = self.now() + timedelta(seconds=self._seconds)
        done = _RENEW(robot=self._robot.pk, epoch=epoch, pid=self.own.pid, until=until)
        with self._lock:
            if epoch != self.epoch:
                return  # it was taken again in the meantime
            if not done:
                self.lost = True
            elif self._lapsed or self._clock.monotonic() >= self._until:
                self._lapsed = True
            else:
                self._until = begun + self._seconds

    def keep(self, running: Callable[[], bool]) -> None:
        """Renew again and again while `running`; while the database is away, try again soon."""
        while running():
            begun = self._clock.monotonic()
            try:
                self.renew()
            except Error:
                close_old_connections()
                self._clock.sleep(0.1)
                continue
            self._clock.sleep(max(0.1, begun + RENEW_S - self._clock.monotonic()))

    def give_back(self) -> None:
        """End the lease at once, so that the next owner need not wait.

        The process is removed from the row too, so that a renewal under way in another thread finds nothing to renew.
        """
        with contextlib.suppress(Exception):
            Lease.objects.filter(robot=self._robot, epoch=self.epoch).update(expires_at=self.now(), pid=0)
        self.lost = True
        self.unlock_device()

    def unlock_device(self) -> None:
        """Close the device lock, as the kernel does when the process ends."""
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None
