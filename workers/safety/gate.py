"""May this process move the robot, right now? Asked last, before every actuation."""

import math
from collections.abc import Container
from dataclasses import dataclass, field
from datetime import datetime

from robots.clock import Clock
from robots.contract.session import Permit
from robots.drivers.errors import GrantOver, NotPermitted, StaleEpoch, Stopped, TooLate
from robots.models import Command, Grant
from workers.safety.latch import StopLatch
from workers.safety.lease import OwnerLease

BEFORE_S = 0.5  # so long before its deadline a command is said at the latest: it has to be planned, too
LAPSED = "The robot's worker lost the robot for a moment; this was not carried out."
TOO_LATE = "It came too late and was not carried out."


def stops(grant_id: int, newest: int, ended: Container[int]) -> bool:
    """Tell whether a stop pressed under that grant is to be heeded.

    Staff's names no grant (0) and always is, so is one under a grant that nothing is known of. One
    grant a robot is open at a time and their numbers grow, so a newer one proves that it has ended.
    """
    return grant_id <= 0 or not (grant_id < newest or grant_id in ended)


class LinkDown(NotPermitted):
    """The live link is gone: nobody could stop the robot round the queue."""

    code = "link_down"


@dataclass
class Gate:
    """Lease, latch, link, grant and deadline in one question, answered from memory."""

    lease: OwnerLease
    latch: StopLatch
    clock: Clock
    link_gone_s: float
    link_seen: float = 0.0
    grant_id: int = 0
    newest: int = 0  # of the grants on this robot that are known to have been opened
    ends: dict[int, float] = field(default_factory=dict)  # until when which grant lasts, by the monotonic clock (s)
    revoked: set[int] = field(default_factory=set)
    begin_by: float | None = None

    def open_for(self, grant: Grant, now: datetime) -> None:
        """Let commands of `grant` through until it ends."""
        self.know(grant, now)
        self.grant_id = grant.pk

    def know(self, grant: Grant, now: datetime) -> None:
        """Note until when a grant lasts, whichever is let through: another thread may open for the next meanwhile."""
        self.newest = max(self.newest, grant.pk)
        if grant.until is None:
            self.ends.pop(grant.pk, None)
        else:
            self.ends[grant.pk] = self.clock.monotonic() + (grant.until - now).total_seconds()

    def know_newest(self, grant: Grant | None) -> None:
        """Note which grant was opened last, whether it goes on or not: what owners before us let through."""
        if grant is not None:
            self.newest = max(self.newest, grant.pk)
            if grant.ended_at is not None:
                self.revoke(grant.pk)

    def expect(self, command: Command, now: datetime) -> None:
        """Let a claimed command begin until shortly before its deadline, whatever holds it up on its way."""
        self.begin_by = self.clock.monotonic() + (command.deadline - now).total_seconds() - BEFORE_S

    def begun(self) -> None:
        """The robot has understood it, or nothing is to begin any more."""
        self.begin_by = None

    @property
    def has_begun(self) -> bool:
        """Tell whether nothing is still to begin."""
        return self.begin_by is None

    def revoke(self, grant_id: int) -> None:
        """Let nothing of that grant through any more."""
        self.revoked.add(grant_id)

    def heeds_stop_of(self, grant_id: int) -> bool:
        """Tell whether a stop that names this grant (0: none) stops; only an end that is known is a reason not to."""
        return stops(grant_id, self.newest, self.revoked)

    @property
    def grant_over(self) -> bool:
        """Tell whether the grant that is let through has ended."""
        grant = self.grant_id
        return grant in self.revoked or self.clock.monotonic() >= self.ends.get(grant, math.inf)

    @property
    def link_down(self) -> bool:
        """Tell whether Redis has been silent for too long."""
        return self.clock.monotonic() - self.link_seen > self.link_gone_s

    def bound(self, epoch: int) -> Permit:
        """Return a permit that is good under this epoch only: once the lease ran out it refuses for ever."""

        def permit() -> None:
            self.check()
            if self.lease.epoch != epoch:
                raise StaleEpoch(LAPSED)

        return permit

    def check(self) -> None:
        """Return if the robot may move. Raises StaleEpoch, Stopped, LinkDown, GrantOver, TooLate."""
        if not self.lease.valid:
            raise StaleEpoch(LAPSED)
        if self.latch.latched:
            raise Stopped("The robot is stopped.")
        if self.link_down:
            raise LinkDown("The live link is down, so nothing moves until it is back.")
        if self.grant_over:
            raise GrantOver("The turn is over.")
        if self.begin_by is not None and self.clock.monotonic() >= self.begin_by:
            raise TooLate(TOO_LATE)
