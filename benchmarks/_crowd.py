"""Many viewers in one process: ``python -m benchmarks._crowd URL VIEWERS SECONDS``.

Prints a JSON line when the first have joined, one when all have, and one after they have watched for so many seconds;
waits for a line on standard input after each. How old a picture is they read in it.
"""

import argparse
import asyncio
import contextlib
import itertools
import json
import random
import sys
import time
from typing import Any
from urllib.parse import urlsplit

import uvloop

from benchmarks._fans import EVERY_S, many_files
from robots.kit.packets import PICTURE_HEAD

FIRST, AT_ONCE = 10, 50  # who join before memory is measured; how many join at a time
SETTLE_S = 2.0
LAST_S, MANY = 5.0, 1_000_000  # without changes at the end; delays that are kept
PICTURE = 2  # the first byte of a picture's message
PING, PONG = 0x89, 0x8A
PAUSE_S, LONGEST_S = 0.4, 8.0  # before a page connects again, doubled with each try


class Viewer(asyncio.Protocol):
    """One viewer: reads frames as they come, and notes the delay of each picture."""

    def __init__(self, crowd: "Crowd", turn: int) -> None:
        """`turn` tells at which of several web processes it has knocked."""
        self.crowd, self.turn = crowd, turn
        self.joined = asyncio.get_running_loop().create_future()
        self._rest, self._left = b"", 0  # the beginning of a head; bytes that the present frame still lacks
        self._sent = 0.0  # when the present frame's picture was published; 0: it is no picture
        self._open = False
        self.count = 0  # of pictures in the present watch
        self.first = self.last = 0.0  # when the first and the last picture were complete

    def connection_made(self, transport: Any) -> None:
        """Ask for a socket, as a page of the site does."""
        self.transport = transport
        transport.write(self.crowd.handshake)

    def data_received(self, data: bytes) -> None:
        """Read frames; nothing of them is kept."""
        if self._rest:
            data, self._rest = self._rest + data, b""
        at = 0 if self._open else self._answered(data)
        while at < len(data):
            if not self._left:
                head = self._head(data, at)
                if not head:
                    self._rest = data[at:]
                    return
                at += head
                if not self._left:
                    continue
            taken = min(self._left, len(data) - at)
            self._left -= taken
            at += taken
            if not self._left and self._sent:
                self.last = time.time()
                self.first = self.first or self.last
                self.count += 1
                self.crowd.note(self.last - self._sent)

    def _answered(self, data: bytes) -> int:
        """Return where the answer of the handshake ends."""
        end = data.find(b"\r\n\r\n")
        if end < 0:
            self._rest = data
            return len(data)
        if not data.startswith(b"HTTP/1.1 101 "):
            raise ValueError(data[:100])
        self._open = True
        self.joined.set_result(None)
        return end + 4

    def _head(self, data: bytes, at: int) -> int:
        """Read the head of a frame; return its length, 0 if more bytes are needed."""
        if len(data) - at < 2:
            return 0
        short = data[at + 1]
        head = {126: 4, 127: 10}.get(short, 2)
        if len(data) - at < head:
            return 0
        size = short if short < 126 else int.from_bytes(data[at + 2 : at + head], "big")
        if data[at] == 0x82 and size >= PICTURE_HEAD.size:
            if len(data) - at < head + PICTURE_HEAD.size:
                return 0
            kind, _, _, at_ms, *_ = PICTURE_HEAD.unpack_from(data, at + head)
            self._sent = at_ms / 1000 if kind == PICTURE else 0.0
        else:
            self._sent = 0.0
            if data[at] == PING:
                if len(data) - at < head + size:
                    return 0
                payload = data[at + head : at + head + size]
                self.transport.write(bytes((PONG, 0x80 | size, 0, 0, 0, 0)) + payload)  # masked with zeros
        self._left = size
        return head

    def connection_lost(self, exc: Exception | None) -> None:
        """Count those that the server has cut off."""
        self.crowd.lost += 1
        if not self.joined.done():
            self.joined.set_exception(exc or ConnectionError("the server closed the connection"))
        elif self.crowd.again:
            self.crowd.viewers.remove(self)
            self.crowd.hold(self.crowd.come_back(self.turn))


class Crowd:
    """The viewers, and what they have noted."""

    def __init__(self, url: str, addresses: int = 0, again: bool = False, also: int = 0) -> None:
        """`addresses`: from how many network addresses they come; `again`: who is cut off comes back, as a page does.

        `also`: the port of a second web process; who finds one of them gone knocks at the other.
        """
        parts = urlsplit(url)
        self.addresses, self.again = addresses, again
        self._tasks: set[asyncio.Task[None]] = set()
        self.host = parts.hostname or "127.0.0.1"
        self._ports = [parts.port or 80, *([also] if also else [])]
        self._turns = itertools.count()
        self.handshake = (
            f"GET {parts.path or '/'} HTTP/1.1\r\nHost: {parts.netloc}\r\nOrigin: http://{parts.netloc}\r\n"
            "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
            "Sec-WebSocket-Version: 13\r\n\r\n"
        ).encode()
        self.viewers: list[Viewer] = []
        self.delays: list[float] = []
        self.lost = 0
        self.noting = False

    def note(self, delay_s: float) -> None:
        """Note that a picture came."""
        if self.noting:
            self.delays.append(delay_s)

    async def join(self, turn: int | None = None) -> None:
        """Add one more viewer, who knocks where it is this turn. Raises OSError if it is refused."""
        turn = next(self._turns) if turn is None else turn
        loop = asyncio.get_running_loop()
        here = (f"127.0.2.{len(self.viewers) % self.addresses + 1}", 0) if self.addresses else None
        _, viewer = await loop.create_connection(
            lambda: Viewer(self, turn), self.host, self._ports[turn % len(self._ports)], local_addr=here
        )
        await viewer.joined
        self.viewers.append(viewer)

    async def come_back(self, turn: int) -> None:
        """Connect again after a random pause, longer after each attempt that failed."""
        for attempt in range(20):
            await asyncio.sleep(min(LONGEST_S, PAUSE_S * 2**attempt) * (0.5 + random.random()))
            with contextlib.suppress(OSError):
                await self.join(turn + 1 + attempt)
                break

    def hold(self, coroutine: Any) -> None:
        """Run something beside the rest."""
        task = asyncio.get_running_loop().create_task(coroutine)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def leave(self) -> None:
        """Remove the viewer that came first."""
        self.viewers.pop(0).transport.abort()
        self.lost -= 1  # it was not lost

    async def watch(self, seconds: float, changes: float = 0.0) -> dict[str, float]:
        """Watch for a while; return what was seen. With changes only the delays of the last minute are kept."""
        self.delays.clear()
        for viewer in self.viewers:
            viewer.count = 0
        self.noting, begun = True, time.time()
        while changes and time.time() - begun < seconds - LAST_S:
            self.leave()
            await asyncio.gather(self.join(), asyncio.sleep(1 / changes))
            if len(self.delays) > MANY:
                self.delays.clear()
        await asyncio.sleep(max(0.0, begun + seconds - time.time()))
        self.noting, took = False, time.time() - begun
        counts = [viewer.count for viewer in self.viewers]
        delays = sorted(self.delays)
        without = sum(viewer.last < begun for viewer in self.viewers)
        back = max((viewer.first for viewer in self.viewers), default=0.0)
        if not delays and not self.again:
            raise RuntimeError("no picture came")
        delays = delays or [0.0]
        return {
            "pictures": len(self.delays),
            "wanted": len(self.viewers) * took / EVERY_S,
            "seconds": took,
            "here": len(self.viewers),
            "fewest": min(counts),
            "most": max(counts),
            "back": back,  # when the last who came back had a picture, s since 1970
            "p95_ms": delays[int(0.95 * len(delays))] * 1000,
            "median_ms": delays[len(delays) // 2] * 1000,
            "p99_ms": delays[int(0.99 * len(delays))] * 1000,
            "most_ms": delays[-1] * 1000,
            "without": without,
            "lost": self.lost,
        }


async def run(asked: argparse.Namespace) -> None:
    """Have them join, then watch."""
    crowd = Crowd(asked.url, asked.addresses, asked.again, asked.also)
    for many in (FIRST, asked.viewers):
        while len(crowd.viewers) < many:
            await asyncio.gather(*(crowd.join() for _ in range(min(AT_ONCE, many - len(crowd.viewers)))))
        await asyncio.sleep(SETTLE_S)
        await told({"joined": len(crowd.viewers)})
    while True:
        await told(await crowd.watch(asked.seconds, asked.changes))


async def told(what: dict[str, float]) -> None:
    """Print a line and wait for an answer."""
    print(json.dumps(what), flush=True)
    if not await asyncio.to_thread(sys.stdin.readline):
        sys.exit()  # nobody listens any more


if __name__ == "__main__":
    many_files()
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("url")
    parser.add_argument("viewers", type=int)
    parser.add_argument("seconds", type=float)
    parser.add_argument("--changes", type=float, default=0.0, help="how many leave, and others join, each second")
    parser.add_argument("--addresses", type=int, default=0, help="of how many network addresses they are")
    parser.add_argument("--again", action="store_true", help="who is cut off comes back")
    parser.add_argument("--also", type=int, default=0, help="the port of a second web process")
    uvloop.run(run(parser.parse_args()))
