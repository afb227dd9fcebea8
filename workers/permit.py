"""May this process move the robot, right now? Asked last, before every actuation."""

from dataclasses import dataclass, field
from datetime import datetime

from robots.clock import Clock
from robots.drivers.errors import GrantOver, NotPermitted, StaleEpoch, Stopped
from robots.models import Grant
from workers.latch import StopLatch
from workers.lease import OwnerLease


class LinkDown(NotPermitted):
    """The live link is gone: nobody could stop the robot round the queue."""

    code = "link_down"


@dataclass
class Gate:
    """Lease, latch, link and grant in one question, answered from memory."""

    lease: OwnerLease
    latch: StopLatch
    clock: Clock
    link_gone_s: float
    link_seen: float = 0.0
    grant_id: int = 0
    grant_until: float | None = None
    revoked: set[int] = field(default_factory=set)

    def open_for(self, grant: Grant, now: datetime) -> None:
        """Let commands of `grant` through until it ends."""
        self.grant_id = grant.pk
        self.grant_until = None
        if grant.until is not None:
            self.grant_until = self.clock.monotonic() + (grant.until - now).total_seconds()

    def revoke(self, grant_id: int) -> None:
        """Let nothing of that grant through any more."""
        self.revoked.add(grant_id)

    @property
    def grant_over(self) -> bool:
        """Tell whether the grant that is let through has ended."""
        over = self.grant_until is not None and self.clock.monotonic() >= self.grant_until
        return over or self.grant_id in self.revoked

    @property
    def link_down(self) -> bool:
        """Tell whether Redis has been silent for too long."""
        return self.clock.monotonic() - self.link_seen > self.link_gone_s

    def check(self) -> None:
        """Return if the robot may move. Raises StaleEpoch, Stopped, LinkDown, GrantOver."""
        if not self.lease.valid:
            raise StaleEpoch("This worker no longer owns the robot.")
        if self.latch.latched:
            raise Stopped("The robot is stopped.")
        if self.link_down:
            raise LinkDown("The live link is down, so nothing moves until it is back.")
        if self.grant_over:
            raise GrantOver("The turn is over.")
