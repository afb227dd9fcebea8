"""What the owner knows of grants, from memory: which ended, and until when each lasts."""

import math
from collections.abc import Container
from datetime import datetime

from robots.clock import Clock
from robots.models import Grant


def stops(grant_id: int, newest: int, ended: Container[int]) -> bool:
    """Tell whether a stop pressed under that grant is to be heeded.

    Staff's names no grant (0) and always is, so is one under a grant that nothing is known of. One
    grant a robot is open at a time and their numbers grow, so a newer one proves that it has ended.
    """
    return grant_id <= 0 or not (grant_id < newest or grant_id in ended)


class KnownGrants:
    """Shared by all lanes and written by the loops that read rows."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self.newest = 0  # of the grants on this robot that are known to have been opened
        self.ended: set[int] = set()
        self._until: dict[int, float] = {}  # by the monotonic clock (s)

    def know(self, grant: Grant, now: datetime) -> None:
        """Note until when a grant lasts, whichever is let through: another thread may open for the next meanwhile."""
        self.newest = max(self.newest, grant.pk)
        if grant.until is None:
            self._until.pop(grant.pk, None)
        else:
            self._until[grant.pk] = self._clock.monotonic() + (grant.until - now).total_seconds()

    def know_newest(self, grant: Grant | None) -> None:
        """Note which grant was opened last, whether it goes on or not: what owners before us let through."""
        if grant is not None:
            self.newest = max(self.newest, grant.pk)
            if grant.ended_at is not None:
                self.revoke(grant.pk)

    def revoke(self, grant_id: int) -> None:
        """Let nothing of that grant through any more."""
        self.ended.add(grant_id)

    def until(self, grant_id: int) -> float:
        """Return when that grant ends by the monotonic clock (s); minus infinity where it has ended already."""
        return -math.inf if grant_id in self.ended else self._until.get(grant_id, math.inf)

    def over(self, grant_id: int) -> bool:
        """Tell whether that grant has ended."""
        return self._clock.monotonic() >= self.until(grant_id)

    def heeds_stop_of(self, grant_id: int) -> bool:
        """Tell whether a stop that names this grant (0: none) stops; only an end that is known is a reason not to."""
        return stops(grant_id, self.newest, self.ended)
