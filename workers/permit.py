"""May this process move the robot, right now? Asked last, before every actuation."""

import math
from dataclasses import dataclass, field
from datetime import datetime

from robots.clock import Clock
from robots.drivers.errors import GrantOver, NotPermitted, StaleEpoch, Stopped, TooLate
from robots.models import Command, Grant
from workers.latch import StopLatch
from workers.lease import OwnerLease

BEFORE_S = 0.5  # so long before its deadline a command is said at the latest: it has to be planned, too
TOO_LATE = "It came too late and was not carried out."


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
    ends: dict[int, float] = field(default_factory=dict)  # until when which grant lasts, by the monotonic clock (s)
    revoked: set[int] = field(default_factory=set)
    begin_by: float | None = None

    def open_for(self, grant: Grant, now: datetime) -> None:
        """Let commands of `grant` through until it ends."""
        self.know(grant, now)
        self.grant_id = grant.pk

    def know(self, grant: Grant, now: datetime) -> None:
        """Note until when a grant lasts, whichever is let through: another thread may open for the next meanwhile."""
        if grant.until is None:
            self.ends.pop(grant.pk, None)
        else:
            self.ends[grant.pk] = self.clock.monotonic() + (grant.until - now).total_seconds()

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

    @property
    def grant_over(self) -> bool:
        """Tell whether the grant that is let through has ended."""
        grant = self.grant_id
        return grant in self.revoked or self.clock.monotonic() >= self.ends.get(grant, math.inf)

    @property
    def link_down(self) -> bool:
        """Tell whether Redis has been silent for too long."""
        return self.clock.monotonic() - self.link_seen > self.link_gone_s

    def check(self) -> None:
        """Return if the robot may move. Raises StaleEpoch, Stopped, LinkDown, GrantOver, TooLate."""
        if not self.lease.valid:
            raise StaleEpoch("This worker no longer owns the robot.")
        if self.latch.latched:
            raise Stopped("The robot is stopped.")
        if self.link_down:
            raise LinkDown("The live link is down, so nothing moves until it is back.")
        if self.grant_over:
            raise GrantOver("The turn is over.")
        if self.begin_by is not None and self.clock.monotonic() >= self.begin_by:
            raise TooLate(TOO_LATE)
