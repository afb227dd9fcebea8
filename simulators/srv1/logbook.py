"""The rover's own journal: what it did, also while nobody heard it. It is in memory, and numbers go on for ever."""

from collections import deque
from collections.abc import Callable

from robots.drivers.srv1.answers import Entries, Entry, Event, encode
from robots.drivers.srv1.protocol import Malformed

ROOM = 256  # entries; older ones are forgotten
MOST_VALUE = 2**31


class Logbook:
    """`uptime_ms` is asked for at each entry. Not for several threads."""

    def __init__(self, uptime_ms: Callable[[], int]) -> None:
        self._uptime_ms = uptime_ms
        self._entries: deque[Entry] = deque(maxlen=ROOM)
        self.newest = 0

    def write(self, event: Event, value: int = 0) -> None:
        """Add an entry."""
        self.newest += 1
        self._entries.append(Entry(self.newest, self._uptime_ms(), event, value % MOST_VALUE))

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
