"""The rover's own journal of what it did, also while it was not connected. In memory; numbers are never used again."""

from collections import deque
from collections.abc import Callable
from math import dist

from robots.kit.drivers.srv1.answers import Entries, Entry, Event, encode
from robots.kit.drivers.srv1.protocol import Malformed

ROOM = 256  # entries; older ones are forgotten
MOST_VALUE = 2**31
ALONE_S, WAY_M = 1.0, 0.5  # after so long without a command it drives alone, and writes its place every so many m
Place = tuple[float, float]


class Logbook:
    """`uptime_ms` and `place` (m) are asked for at each entry. Not for several threads."""

    def __init__(self, uptime_ms: Callable[[], int], place: Callable[[], Place]) -> None:
        self._uptime_ms, self._place = uptime_ms, place
        self._alone: Place | None = None  # the place of its last entry while it drives by itself
        self._entries: deque[Entry] = deque(maxlen=ROOM)
        self.newest = 0

    def write(self, event: Event, value: int = 0) -> None:
        """Add an entry."""
        self.newest += 1
        self._entries.append(Entry(self.newest, self._uptime_ms(), event, value % MOST_VALUE, *self._place()))

    def follow(self, patrols: bool, silent_s: float, motion: int) -> None:
        """Write the way of a patrol during which no command has come for `silent_s`."""
        here = self._place()
        if not patrols:
            self._alone = None
        elif silent_s <= ALONE_S:
            if self._alone is not None:
                self.write(Event.HEARD, motion)
            self._alone = None
        elif self._alone is None or dist(here, self._alone) >= WAY_M:
            self.write(Event.ALONE if self._alone is None else Event.WAY, motion)
            self._alone = here

    def after(self, number: int) -> Entries:
        """Return the oldest entries after that number, as many as an answer takes."""
        chosen: tuple[Entry, ...] = ()
        for entry in self._entries:
            if entry.number > number:
                try:
                    encode(Entries((*chosen, entry)))
                except Malformed:  # no room for one more
                    break
                chosen = (*chosen, entry)
        return Entries(chosen)
