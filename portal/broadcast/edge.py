"""The state of an edge: the present movie, the movie before it, and the bytes to fetch. No socket, no clock."""

import logging
from collections.abc import Callable
from dataclasses import replace

from portal.broadcast import packets
from portal.broadcast.assembly import MOST, Assembly, Gap
from portal.broadcast.timetable import SECOND

log = logging.getLogger(__name__)
BEFORE_NS = SECOND // 20  # bytes that are missing so soon before they are needed count as lost: half the guard
PAUSE_NS = SECOND // 20  # after a loss, at least: packets may overtake one another
SPREAD_NS = SECOND  # edges that lose the same packet do not ask all at once
AGAIN_NS = SECOND // 2  # a request without an answer is repeated after it
PLACES = 100_000  # of gaps that are remembered
LONGEST = 256 * 1024  # bytes of a request
SILENCE_NS = 10 * SECOND  # after that, an origin whose clock was set back is believed
GONE_NS = 60 * SECOND  # after that silence a movie is forgotten: it may have been withdrawn
LATER_NS = 60 * SECOND  # viewers may have begun late, or paused
RESTART = 100_000  # so many skipped numbers mean another start of the origin, no loss


class Edge:
    """Takes datagrams; `random` gives numbers from 0 to below 1. All movies together have at most `most` bytes."""

    def __init__(self, key: bytes, random: Callable[[], float], most: int = MOST) -> None:
        self.key, self._random, self._most = key, random, most
        self.current: Assembly | None = None
        self.before: Assembly | None = None
        self.packets_received = self.refused = self.packets_lost = 0
        self.repaired = 0  # bytes
        self._number, self._heard_ns = 0, 0
        self._ask_ns: dict[tuple[int, int], int] = {}  # when each gap may be asked for, by its segment and beginning

    def hear(self, datagram: bytes, now_ns: int) -> None:
        """Take a datagram that came to the group's address."""
        packet = packets.decode(self.key, datagram)
        if packet is None:
            self.refused += 1
            return
        movie = self.current
        if movie is None or packet.movie != movie.movie:
            if movie is not None and packet.number <= self._number and now_ns - self._heard_ns < SILENCE_NS:
                self.refused += 1  # somebody sends again what was sent once
                return
            movie = self._begin(packet, now_ns)
        self._count(packet.number, now_ns)
        try:
            fits = movie.take(packet)
        except ValueError as error:
            self._drop(movie, error)
            return
        self.refused += not fits
        if self.before is not None and self.before.size + movie.size > self._most:
            self.before = None

    def _begin(self, packet: packets.Packet, now_ns: int) -> Assembly:
        if self.current is not None and self.current.index is not None:
            self.before = self.current
        self.current = Assembly(packet.movie, packet.wait_ds, now_ns, self._most)
        self._ask_ns.clear()
        self._number = 0
        log.info("movie %08x begins", packet.movie)
        return self.current

    def _count(self, number: int, now_ns: int) -> None:
        skipped = number - self._number - 1
        if self._number and 0 < skipped < RESTART:
            self.packets_lost += skipped
        if number > self._number or now_ns - self._heard_ns >= SILENCE_NS:
            self._number = number
        self.packets_received, self._heard_ns = self.packets_received + 1, now_ns

    def _drop(self, movie: Assembly, error: ValueError) -> None:
        log.warning("movie %08x has an index that is none: %s", movie.movie, error)
        self.refused += 1
        self.current = None

    def forget(self, now_ns: int) -> None:
        """Forget a movie that is no longer sent, and the movie before when its viewers have seen its end."""
        if self.current is not None and now_ns - self._heard_ns > GONE_NS:
            log.info("movie %08x is no longer sent", self.current.movie)
            self.current = self.before = None
        before, after = self.before, self.current
        if before is not None and before.index is not None and after is not None:
            long_ns = (before.index.starts_ms[-1] + before.index.durations_ms[-1]) * SECOND // 1000
            if now_ns - after.joined_ns > after.wait_ns + long_ns + LATER_NS:
                self.before = None

    def find(self, movie: int) -> Assembly | None:
        """Return a movie that people may still be watching."""
        return next((one for one in (self.current, self.before) if one is not None and one.movie == movie), None)

    def requests_due(self, now_ns: int, most: int) -> list[Gap]:
        """Return the gaps to request from the origin now, at most `most`; a request without an answer is repeated."""
        movie, asked = self.current, []
        if movie is None or movie.whole or most <= 0:
            return []
        if len(self._ask_ns) > PLACES:
            self._ask_ns.clear()
        for gap in movie.gaps(now_ns, BEFORE_NS):
            place = gap.segment, gap.begin
            at = self._ask_ns.setdefault(place, now_ns + self._pause_ns(gap.due_ns - now_ns))
            if at <= now_ns:
                self._ask_ns[place] = now_ns + AGAIN_NS
                asked.append(replace(gap, end=min(gap.end, gap.begin + LONGEST)))
                if len(asked) >= most:
                    break
        return asked

    def _pause_ns(self, left_ns: int) -> int:
        """Return how long a request can wait: other edges lost the bytes, too, and packets may overtake one another."""
        if left_ns <= BEFORE_NS:
            return 0
        least = min(PAUSE_NS, left_ns // 2)
        return least + int(self._random() * (min(SPREAD_NS, left_ns // 2) - least))

    def repair(self, movie: int, gap: Gap, data: bytes, size: int) -> None:
        """Take an answer of the origin: bytes from the gap's beginning on, of a segment of `size` bytes."""
        current = self.current
        if current is None or current.movie != movie:
            return
        try:
            fits = current.repair(gap, data, size)
        except ValueError as error:
            self._drop(current, error)
            return
        self.repaired += len(data) if fits else 0
        if fits:
            self._ask_ns.pop((gap.segment, gap.begin), None)

    def status(self) -> dict[str, object]:
        """Return the counters of this edge, for people and monitors."""
        movie = self.current
        return {
            "movie": None if movie is None else f"{movie.movie:08x}",
            "shown": 0 if movie is None else movie.playable,
            "segments": 0 if movie is None else movie.count,
            "whole": movie is not None and movie.whole,
            "packets": self.packets_received, "refused": self.refused, "lost": self.packets_lost,
            "repaired_bytes": self.repaired,
        }  # fmt: skip
