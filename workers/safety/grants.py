"""The owner's knowledge of grants, in memory: which have ended, and when each ends."""

import math
from collections.abc import Container
from datetime import datetime

from robots.clock import Clock
from robots.models import Grant


def stops(grant_id: int, newest: int, ended: Container[int]) -> bool:
    """Return whether a stop that was pressed under a grant counts.

    A stop of staff names no grant (0) and always counts; so does a stop under an unknown grant. A robot has one open
    grant at a time and the numbers grow, so a newer grant proves that an older one has ended.
    """
    return grant_id <= 0 or not (grant_id < newest or grant_id in ended)


class KnownGrants:
    """Shared by all lanes; written by the loops that read rows."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self.newest = 0  # the newest known grant of this robot
        self.ended: set[int] = set()
        self._until: dict[int, float] = {}  # by the monotonic clock (s)

    def know(self, grant: Grant, now: datetime) -> None:
        """Note until when a grant lasts."""
        self.newest = max(self.newest, grant.pk)
        if grant.until is None:
            self._until.pop(grant.pk, None)
        else:
            self._until[grant.pk] = self._clock.monotonic() + (grant.until - now).total_seconds()

    def know_newest(self, grant: Grant | None) -> None:
        """Note which grant was opened last, whether or not it is still open."""
        if grant is not None:
            self.newest = max(self.newest, grant.pk)
            if grant.ended_at is not None:
                self.revoke(grant.pk)

    def revoke(self, grant_id: int) -> None:
        """Let no command of that grant pass any more."""
        self.ended.add(grant_id)

    def until(self, grant_id: int) -> float:
        """Return when that grant ends by the monotonic clock (s); minus infinity if it has ended."""
        return -math.inf if grant_id in self.ended else self._until.get(grant_id, math.inf)

    def over(self, grant_id: int) -> bool:
        """Return whether that grant has ended."""
        return self._clock.monotonic() >= self.until(grant_id)

    def stop_counts(self, grant_id: int) -> bool:
        """Return whether a stop that names this grant (0: none) counts: not if the grant is known to have ended."""
        return stops(grant_id, self.newest, self.ended)
