"""The packets of a broadcast in the order and at the times of its timetable; no socket, and the time is given."""

import heapq
from collections.abc import Sequence

from portal.broadcast import packets
from portal.broadcast.timetable import SECOND, Channel, channels

GUARD_NS = SECOND // 10
STALLED_NS = 2 * SECOND  # later packets are left out, as if they had been lost: no flood after a long pause
DS_NS = SECOND // 10  # a tenth of a second


class Carousel:
    """Sends the segments of a movie, the index first, from `began_ns` on."""

    def __init__(
        self, key: bytes, contents: Sequence[bytes], starts_ns: Sequence[int], wait_ds: int, began_ns: int,
        number: int, guard_ns: int = GUARD_NS,
    ) -> None:  # fmt: skip
        self._key, self._wait_ds, self._number = key, wait_ds, number
        self.contents = tuple(contents)
        self.movie = packets.movie_of(self.contents)
        sizes = [len(content) for content in contents]
        self.channels: tuple[Channel, ...] = channels(sizes, starts_ns, wait_ds * DS_NS, guard_ns)
        self.rate = sum(one.packets * SECOND / one.period_ns for one in self.channels)  # packets a second
        self._began = began_ns
        self.packets = self.bytes = 0  # that were made, and their bytes without headers of UDP and IP
        self.skipped, self.late_ns = 0, 0  # long pauses; how late the latest packet was
        self._next: list[tuple[int, int, int]] = []  # when, of which channel, which packet
        self._go_on(0)

    def _go_on(self, since_ns: int) -> None:
        """Go on with the first packet of each channel that is not before this moment of the timetable."""
        firsts = [(one, one.first(since_ns)) for one in self.channels]
        self._next = [(one.at(n), one.segment, n) for one, n in firsts]
        heapq.heapify(self._next)

    @property
    def next_ns(self) -> int:
        """Return when the next packet is due (ns)."""
        return self._began + self._next[0][0]

    def due(self, now_ns: int, most: int) -> list[bytes]:
        """Return the packets that are due now, at most `most`."""
        self.late_ns = max(self.late_ns, now_ns - self.next_ns)
        if now_ns - self.next_ns > STALLED_NS:
            self.skipped += 1
            self._go_on(now_ns - self._began)
        made: list[bytes] = []
        while self.next_ns <= now_ns and len(made) < most:
            _, segment, n = self._next[0]
            one = self.channels[segment]
            heapq.heapreplace(self._next, (one.at(n + 1), segment, n + 1))
            made.append(self._packet(one, n))
            self.packets, self.bytes = self.packets + 1, self.bytes + len(made[-1])
        return made

    def _packet(self, one: Channel, n: int) -> bytes:
        begin, end = one.piece(n)
        self._number += 1
        return packets.encode(
            self._key,
            packets.Packet(
                self.movie, self._number, self._wait_ds, one.segment, begin, one.size,
                self.contents[one.segment][begin:end],
            ),
        )  # fmt: skip
