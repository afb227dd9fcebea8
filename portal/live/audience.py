"""The watchers of each robot and the bytes sent to them: counted in memory, added to the database each minute.

Nobody is named. A process that is killed loses the counts of its last minute.
"""

import asyncio
import contextlib
import logging
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime

from django.db import Error

from portal.live.threads import ANYBODY
from robots.kit.clock import SYSTEM
from robots.models import Robot
from robots.services import note_usage, slot_of

log = logging.getLogger(__name__)
EVERY_S = 60.0


@dataclass(frozen=True)
class Increment:
    """The numbers to be added to the counters of a robot."""

    slug: str
    watching: int
    sent_bytes: int


@dataclass(eq=False)
class Seat:
    """One watcher; `sent_bytes` counts the bytes that are sent to it alone."""

    sent_bytes: int = 0


class Audience:
    """The watchers of one event loop."""

    def __init__(self) -> None:
        self._here: dict[str, set[Seat]] = {}  # by robot
        self._most = Counter[str]()  # since the last time that it was written
        self._sent = Counter[str]()  # to those who have gone, and to several at once
        self._told = Counter[str]()  # the most watchers that the counters of these five minutes have already
        self._slot: datetime | None = None
        self._task: asyncio.Task[None] | None = None

    @contextlib.contextmanager
    def one(self, slug: str) -> Iterator[Seat]:
        """Count a watcher during the body of a `with` statement."""
        seat, seats = Seat(), self._here.setdefault(slug, set())
        seats.add(seat)
        self._most[slug] = max(self._most[slug], len(seats))
        if self._task is None or self._task.done():
            self._task = asyncio.create_task(self._keep())
        try:
            yield seat
        finally:
            self._sent[slug] += seat.sent_bytes
            seats.discard(seat)
            if not seats:
                self._here.pop(slug, None)

    def add_sent(self, slug: str, count: int) -> None:
        """Count bytes that were sent to several watchers at once."""
        self._sent[slug] += count

    def take(self, now: datetime) -> tuple[datetime, list[Increment]]:
        """Return the present five minutes and what is to be added to them; nothing of it is returned again."""
        slot = slot_of(now)
        if slot != self._slot:
            self._slot, self._told = slot, Counter()
        for slug, seats in self._here.items():
            for seat in seats:
                self._sent[slug] += seat.sent_bytes
                seat.sent_bytes = 0
        counted = []
        for slug in self._most.keys() | self._sent.keys():
            more = max(0, self._most[slug] - self._told[slug])
            self._told[slug] += more
            if more or self._sent[slug]:
                counted.append(Increment(slug, more, self._sent[slug]))
        self._sent.clear()
        self._most = Counter({slug: len(seats) for slug, seats in self._here.items()})
        return slot, counted

    async def _keep(self) -> None:
        """Write each minute, and once after the last watcher has gone."""
        while True:
            await asyncio.sleep(EVERY_S)
            slot, counted = self.take(SYSTEM.now())
            try:
                await ANYBODY.orm(write)(slot, counted)
            except Error as error:
                log.warning("what visitors were sent in this minute is not counted: %s", error)
            if not self._here and not self._sent:
                return


def write(slot: datetime, counted: list[Increment]) -> None:
    """Add to the counters; robots that were removed meanwhile are left out."""
    keys = dict(Robot.objects.filter(slug__in=[one.slug for one in counted]).values_list("slug", "pk"))
    for one in counted:
        if one.slug in keys:
            note_usage(keys[one.slug], slot, watching=one.watching, sent_bytes=one.sent_bytes)
