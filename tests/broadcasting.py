"""A movie of random bytes, its origin, and edges that hear it in a network that loses packets; in a time of its own."""

import random

from portal.broadcast import index, packets, repairs
from portal.broadcast.carousel import Carousel
from portal.broadcast.edge import Edge
from portal.broadcast.media import Movie
from portal.broadcast.repairs import Repairs
from portal.broadcast.timetable import SECOND

KEY = packets.key_of("only for tests, " * 2)
MS = SECOND // 1000
STEP_NS, LOOK_NS, ROUND_NS = 2 * MS, 20 * MS, 10 * MS  # a step; between looks for gaps; an HTTP answer


def movie(count=12, size=6000, slot_ms=500, seed=1):
    """Return a movie of so many segments of about so many bytes."""
    numbers = random.Random(seed)
    media = [numbers.randbytes(numbers.randint(size // 2, 3 * size // 2)) for _ in range(count)]
    starts = [n * slot_ms for n in range(count)]
    made = index.Index("avc1.64000d", numbers.randbytes(800), starts, [slot_ms] * count, True)
    return Movie(made, (index.encode(made), *media), (0, *(ms * MS for ms in starts)))


class Air:
    """An origin, and edges that each lose this share of its packets; `wait_ds` in tenths of a second."""

    def __init__(self, shown, wait_ds=20, now_ns=1000 * SECOND, number=10**6):
        self.now_ns, self.number = now_ns, number
        self.edges, self.late, self.repairing = {}, [], True
        self.asked = 0  # bytes that were fetched
        self._shown, self._flying = {}, []  # of each edge: when it had each segment; answers that are on the way
        self.broadcast(shown, wait_ds)

    def broadcast(self, shown, wait_ds=20):
        """Start the origin, with this movie."""
        self.number += 10**6
        self.movie = shown
        self.carousel = Carousel(KEY, shown.contents, shown.starts_ns, wait_ds, self.now_ns, self.number)
        self.origin = Repairs(self.carousel, KEY, 10**7, lambda: self.now_ns)

    def join(self, loss=0.0, seed=1):
        """Return an edge that joins now."""
        numbers = random.Random(seed)
        edge = Edge(KEY, numbers.random)
        self.edges[edge] = loss, numbers
        return edge

    def go(self, seconds, sending=True):
        """Let time pass."""
        until = self.now_ns + round(seconds * SECOND)
        while self.now_ns < until:
            self.now_ns += STEP_NS
            for datagram in self.carousel.due(self.now_ns, 32) if sending else ():
                for edge, (loss, numbers) in self.edges.items():
                    if numbers.random() >= loss:
                        edge.hear(datagram, self.now_ns)
            if self.now_ns % LOOK_NS == 0:
                for edge in self.edges:
                    edge.forget(self.now_ns)
                self._ask() if self.repairing else None
            self._arrive()
            self._look()

    def _ask(self):
        for edge in self.edges:
            for gap in edge.requests_due(self.now_ns, 4):
                movie = edge.current.movie
                answer = self.origin.answer(repairs.path_of(movie, gap), {"range": repairs.range_of(gap)})
                self._flying.append((self.now_ns + ROUND_NS, edge, movie, gap, answer))

    def _arrive(self):
        arrived = [one for one in self._flying if one[0] <= self.now_ns]
        self._flying = [one for one in self._flying if one[0] > self.now_ns]
        for _, edge, movie, gap, answer in arrived:
            taken = repairs.verify(KEY, movie, gap, answer)
            if taken is not None:
                self.asked += len(taken[0])
                edge.repair(movie, gap, *taken)

    def _look(self):
        """Note each segment that is not there when it is shown to whoever joined with the edge."""
        for edge in self.edges:
            one = edge.current
            if one is None or one.movie != self.carousel.movie:
                continue
            next_number = self._shown.setdefault((edge, one.movie), 1)
            start = self.movie.starts_ns[next_number] if next_number < len(self.movie.starts_ns) else None
            if start is not None and self.now_ns >= one.joined_ns + one.wait_ns + start:
                self._shown[edge, one.movie] += 1
                if one.playable < next_number:
                    self.late.append((edge, next_number))


def same(edge, shown):
    """Tell whether an edge has every byte of a movie."""
    one = edge.current
    return one is not None and one.whole and [
        bytes(one.segments[n].data) for n in range(one.count + 1)
    ] == list(shown.contents)  # fmt: skip
