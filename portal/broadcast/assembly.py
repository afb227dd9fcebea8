"""Puts a movie together from its packets, and lists the gaps with their deadlines. No I/O."""

from dataclasses import dataclass, field

from portal.broadcast import index
from portal.broadcast.carousel import DS_NS
from portal.broadcast.packets import LARGEST, Packet
from portal.broadcast.timetable import SECOND

MOST = 256 * 1024 * 1024  # bytes of a movie


@dataclass(frozen=True)
class Gap:
    """Bytes of a segment that are not there, from `begin` to before `end`; needed at `due_ns`.

    `all`: nothing of the segment is there, and its size is not known.
    """

    segment: int
    begin: int
    end: int
    due_ns: int

    @property
    def all(self) -> bool:
        """Return whether the whole segment is missing, and with it its size."""
        return self.end == 0


@dataclass
class Segment:
    """The bytes of a segment as far as they have come."""

    data: bytearray
    missing_ranges: list[tuple[int, int]]  # in order, apart from one another
    lost_ranges: list[tuple[int, int]] = field(default_factory=list)  # sent, but not received
    after: int | None = None  # the end of the packet that was received last

    @property
    def whole(self) -> bool:
        """Return whether all of it is there."""
        return not self.missing_ranges

    def within(self, begin: int, end: int) -> list[tuple[int, int]]:
        """Return what is missing between two places."""
        return [(max(a, begin), min(b, end)) for a, b in self.missing_ranges if a < end and b > begin]

    def put(self, begin: int, data: bytes) -> None:
        """Store bytes at this place; bytes that are there already stay as they are."""
        end = begin + len(data)
        for a, b in self.within(begin, end):
            self.data[a:b] = data[a - begin : b - begin]
        self.missing_ranges = _without(self.missing_ranges, begin, end)
        self.lost_ranges = _without(self.lost_ranges, begin, end)

    def take_packet(self, begin: int, data: bytes) -> None:
        """Store a packet, and note the bytes between it and the packet before as lost."""
        size, after = len(self.data), self.after
        self.after = (begin + len(data)) % size
        if after is not None and after != begin:
            passed = [(after, begin)] if after < begin else [(after, size), (0, begin)]
            lost = {gap for a, b in passed for gap in self.within(a, b)}
            self.lost_ranges = sorted({*self.lost_ranges, *lost})
        self.put(begin, data)


def _without(gaps: list[tuple[int, int]], begin: int, end: int) -> list[tuple[int, int]]:
    left: list[tuple[int, int]] = []
    for a, b in gaps:
        left += [(a, b)] if b <= begin or a >= end else [(x, y) for x, y in ((a, begin), (end, b)) if x < y]
    return left


class Assembly:
    """One movie that an edge has received since `joined_ns`. At most `most` bytes."""

    def __init__(self, movie: int, wait_ds: int, joined_ns: int, most: int = MOST) -> None:
        self.movie, self.joined_ns, self.wait_ns = movie, joined_ns, wait_ds * DS_NS
        self.segments: dict[int, Segment] = {}
        self.index: index.Index | None = None
        self.size = 0  # bytes of the segments that are known
        self._most, self._open = most, {0, 1}  # the numbers of the segments that are not whole, as far as known
        self._lossy: set[int] = set()  # of the numbers whose packets were lost
        self._shown = 0

    def take(self, packet: Packet) -> bool:
        """Take a packet of this movie. Return whether it fits. Raises ValueError as `repair` does."""
        segment = self._segment(packet.segment, packet.size)
        if segment is None:
            return False
        if not segment.whole:
            segment.take_packet(packet.offset, packet.data)
            if segment.lost_ranges:
                self._lossy.add(packet.segment)
            self._judge(packet.segment, segment)
        return True

    def repair(self, gap: Gap, data: bytes, size: int) -> bool:
        """Take fetched bytes. Return whether they fit. Raises ValueError if they complete an invalid index."""
        segment = self._segment(gap.segment, size)
        if segment is None or gap.begin + len(data) > len(segment.data):
            return False
        if not segment.whole:
            segment.put(gap.begin, data)
            self._judge(gap.segment, segment)
        return True

    def _segment(self, number: int, size: int) -> Segment | None:
        segment = self.segments.get(number)
        if segment is not None:
            return segment if len(segment.data) == size else None
        most = min(LARGEST if number else index.LARGEST, self._most - self.size)
        if not 0 < size <= most or (self.index is not None and number > self.count):
            return None
        self.size += size
        self._open.add(number)
        self.segments[number] = made = Segment(bytearray(size), [(0, size)])
        return made

    def _judge(self, number: int, segment: Segment) -> None:
        if not segment.whole:
            return
        self._open.discard(number)
        self._lossy.discard(number)
        if number == 0:
            self.index = index.decode(bytes(segment.data))
            self._open |= set(range(1, self.count + 1)) - {n for n, one in self.segments.items() if one.whole}
            self._open -= {n for n in self._open if n > self.count}
        while (after := self.segments.get(self._shown + 1)) is not None and after.whole:
            self._shown += 1

    @property
    def count(self) -> int:
        """Return how many segments the movie has besides the index; 0 while that is not known."""
        return 0 if self.index is None else len(self.index.starts_ms)

    @property
    def whole(self) -> bool:
        """Return whether all of it is there."""
        return self.index is not None and not self._open

    @property
    def playable(self) -> int:
        """Return how many of the segments 1, 2 and so on are there without a gap; the playlist names these."""
        return min(self._shown, self.count)

    def due_ns(self, number: int) -> int | None:
        """Return when a viewer who joined with us needs this segment; None while it is not known."""
        if number < 2:
            return self.joined_ns + self.wait_ns
        if number > self.count or self.index is None:
            return None
        return self.joined_ns + self.wait_ns + self.index.starts_ms[number - 1] * SECOND // 1000

    def gaps(self, now_ns: int, before_ns: int) -> list[Gap]:
        """Return the gaps that have to be fetched, the most urgent first.

        These are bytes that were lost, and bytes that are needed within `before_ns` and are not there.
        """
        found = []
        for number in sorted(self._due_soon(now_ns + before_ns) | self._lossy):
            segment, due = self.segments.get(number), self.due_ns(number)
            if due is not None and due <= now_ns + before_ns:
                missing = [(0, 0)] if segment is None else segment.missing_ranges
            else:
                missing = [] if segment is None else segment.lost_ranges
            found += [Gap(number, a, b, due or now_ns + self.wait_ns) for a, b in missing]
        return sorted(found, key=lambda gap: (gap.due_ns, gap.segment, gap.begin))

    def _due_soon(self, until_ns: int) -> set[int]:
        """Return the segments that are needed until then and are not whole; they are needed in ascending order."""
        soon = {0} & self._open
        for number in range(self._shown + 1, max(1, self.count) + 1):
            due = self.due_ns(number)
            if due is None or due > until_ns:
                break
            if number in self._open:
                soon.add(number)
        return soon
