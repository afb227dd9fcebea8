"""Byte streams as the suite hears them, with the owner's rules."""

import threading
from collections.abc import Iterator
from dataclasses import dataclass

from robots.kit.contract.spec import Spec
from robots.kit.contract.streams import LONGEST

ASKS = 40  # deltas after which the suite asks for a key packet
ON_THE_WAY = 50  # packets that may still come after that


@dataclass
class StreamCount:
    """The count of one stream: packets, deltas since its key packet, and those since a key packet was asked for."""

    packets: int = 0
    deltas: int = 0
    late: int = 0
    first: bool = True  # nothing came since the session was opened


class Recorder:
    """Takes packets from any thread. It tells what was wrong as sentences, each once."""

    def __init__(self, spec: Spec) -> None:
        self.counts = {stream.name: StreamCount() for stream in spec.streams}
        self._wrong: dict[str, None] = {}
        self._lock = threading.Lock()

    def take(self, name: str, data: bytes, key: bool) -> bool:
        """Take a packet; True if the next one has to be a key packet. Raises ValueError, as the owner's."""
        with self._lock:
            if name not in self.counts:
                raise self._refused(f"It sends the stream {name!r}; declare it in the spec's streams.")
            if not isinstance(data, bytes | bytearray | memoryview):
                raise self._refused(f"A packet of the stream {name!r} is {type(data).__name__}; send bytes.")
            if len(data) > LONGEST:
                raise self._refused(
                    f"A packet of the stream {name!r} has {len(data)} bytes; send at most {LONGEST} (1 MiB)."
                )
            return self._take(self.counts[name], name, key)

    def _refused(self, words: str) -> ValueError:
        self._wrong[words] = None
        return ValueError(words)

    def _take(self, heard: StreamCount, name: str, key: bool) -> bool:
        heard.packets += 1
        if heard.first and not key:
            self._wrong[f"The stream {name!r} begins with a delta; send a key packet first."] = None
        heard.first = False
        heard.deltas = 0 if key else heard.deltas + 1
        if heard.deltas > ASKS + ON_THE_WAY:
            words = f"The stream {name!r} sends no key packet although stream() returned True {ON_THE_WAY} times."
            self._wrong[words] = None
        return heard.deltas >= ASKS

    def again(self) -> None:
        """Expect a key packet next: a new session does not know the packets of the last one."""
        with self._lock:
            for heard in self.counts.values():
                heard.first, heard.deltas = True, 0

    def wrong(self) -> Iterator[str]:
        """Yield what was wrong."""
        with self._lock:
            yield from list(self._wrong)
