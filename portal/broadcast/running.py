"""Origin and edge at work: sockets and tasks around the pure code of the other files, by the time of the event loop."""

import asyncio
import logging
import math
import socket
from collections.abc import Callable
from typing import NamedTuple

from portal.broadcast import repairs
from portal.broadcast.assembly import Gap
from portal.broadcast.carousel import Carousel
from portal.broadcast.edge import Edge
from portal.broadcast.packets import DATAGRAM
from portal.broadcast.timetable import SECOND

log = logging.getLogger(__name__)
LEAST, PAUSE_S = 4, 0.001  # packets without a pause, and the pause: sockets of edges have room for few
FASTER = 4  # after a pause packets are sent at most so many times faster than they are due
LOOK_S = 0.02  # an edge reads packets and looks for gaps so often: cheaper than to wake for each packet
AT_ONCE = 4  # requests of an edge to the origin
IDLE_S = 0.5  # between two looks for a carousel while there is none
READ = 1000  # datagrams at a look; more of them wait in the socket


def now_ns() -> int:
    """Return the time of the event loop (ns)."""
    return round(asyncio.get_running_loop().time() * SECOND)


class Line(NamedTuple):
    """A socket (that does not block) and the group that it sends to or hears."""

    socket: socket.socket
    group: tuple[str, int]


class Sending:
    """Sends a carousel's packets to a group, for as long as `run` runs; another one, or none, may take its place."""

    def __init__(self, carousel: Carousel | None, line: Line) -> None:
        self.carousel, self._line = carousel, line
        self.packets = self.bytes = self.failed = 0

    async def run(self) -> None:
        """Send each packet when it is due."""
        while True:
            carousel = self.carousel
            if carousel is None:
                await asyncio.sleep(IDLE_S)
                continue
            now = now_ns()
            for datagram in carousel.due(now, max(LEAST, math.ceil(FASTER * carousel.rate * PAUSE_S))):
                self._send(datagram)
            await asyncio.sleep(max(PAUSE_S, (carousel.next_ns - now) / SECOND))

    def _send(self, datagram: bytes) -> None:
        try:
            self._line.socket.sendto(datagram, self._line.group)
        except OSError as error:  # no room, or no network for now: for edges it is lost, as on the way
            if not self.failed:
                log.warning("a packet of the broadcast could not be sent: %s", error)
            self.failed += 1
            return
        self.packets, self.bytes = self.packets + 1, self.bytes + len(datagram)


class Receiving:
    """Receives a group for an edge, and fetches its gaps from the origin, if it has the address of one."""

    def __init__(self, edge: Edge, line: Line, origin: str = "", loses: Callable[[], bool] = lambda: False) -> None:
        self._edge, self._line, self._origin, self._loses = edge, line, origin, loses
        self._fetching: set[asyncio.Task[None]] = set()

    async def run(self) -> None:
        """Hear and fetch."""
        try:
            while True:
                await asyncio.sleep(LOOK_S)
                self._read()
                self._edge.forget(now_ns())
                if self._origin:
                    self._fetch()
        finally:
            for task in self._fetching:
                task.cancel()

    def _read(self) -> None:
        now = now_ns()
        for _ in range(READ):
            try:
                datagram = self._line.socket.recv(DATAGRAM + 1)  # one byte more: a longer one is refused
            except BlockingIOError:
                return
            except OSError as error:
                log.warning("the group cannot be heard: %s", error)
                return
            if not self._loses():
                self._edge.hear(datagram, now)

    def _fetch(self) -> None:
        movie = self._edge.current
        for gap in self._edge.requests_due(now_ns(), AT_ONCE - len(self._fetching)):
            if movie is not None:
                task = asyncio.ensure_future(self._repair(movie.movie, gap))
                self._fetching.add(task)
                task.add_done_callback(self._fetching.discard)

    async def _repair(self, movie: int, gap: Gap) -> None:
        answer = await repairs.fetch(self._origin, movie, gap)
        taken = None if answer is None else repairs.verify(self._edge.key, movie, gap, answer)
        if taken is not None:
            self._edge.repair(movie, gap, *taken)
