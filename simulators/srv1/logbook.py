"""The rover's own journal: what it did, also while nobody heard it. It is in memory, and numbers go on for ever."""

from collections import deque
from collections.abc import Callable
from math import dist

from robots.kit.drivers.srv1.answers import Entries, Entry, Event, encode
from robots.kit.drivers.srv1.protocol import Malformed

ROOM = 256  # entries; older ones are forgotten
MOST_VALUE = 2**31
ALONE_S, WAY_M = 1.0, 0.5  # without a word for so long it is alone; then it writes where it is once in so far
Place = tuple[float, float]


class Logbook:
    """`uptime_ms` and `place` (m) are asked for at each entry. Not for several threads."""

    def __init__(self, uptime_ms: Callable[[], int], place: Callable[[], Place]) -> None:
        self._uptime_ms, self._place = uptime_ms, place
        self._alone: Place | None = None  # where it was when it wrote that it drives by itself
        self._entries: deque[Entry] = deque(maxlen=ROOM)
        self.newest = 0

    def write(self, event: Event, value: int = 0) -> None:
        """Add an entry."""
        self.newest += 1
        self._entries.append(Entry(self.newest, self._uptime_ms(), event, value % MOST_VALUE, *self._place()))

    def follow(self, patrols: bool, silent_s: float, motion: int) -> None:
        """Write the way that it patrols without a word; `silent_s`: since when."""
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
