"""Many viewers in one process: ``python -m benchmarks._crowd URL VIEWERS SECONDS [CHANGES]``.

Prints a JSON line when the first have joined, one when all have, and one after they have watched for so many seconds;
waits for a line on standard input after each. While they watch, CHANGES of them leave and others join each second.
"""

import asyncio
import json
import sys
import time
from typing import Any
from urllib.parse import urlsplit

import uvloop

from benchmarks._fans import EVERY_S, HEAD, many_files

FIRST, AT_ONCE = 10, 50  # who join before memory is measured; how many join at a time
SETTLE_S = 2.0
LAST_S, MANY = 5.0, 1_000_000  # without changes at the end; delays that are kept
PICTURE = 2  # the first byte of a picture's message


class Viewer(asyncio.Protocol):
    """One viewer: reads frames as they come, and notes the delay of each picture."""

    def __init__(self, crowd: "Crowd") -> None:
        self.crowd = crowd
        self.joined = asyncio.get_running_loop().create_future()
        self._rest, self._left = b"", 0  # the beginning of a head; bytes that the present frame still lacks
        self._sent = 0.0  # when the present frame's picture was published; 0: it is no picture
        self._open = False
        self.last = 0.0  # when the last picture was complete

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
                self.last = time.monotonic()
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
        if data[at] == 0x82 and size >= HEAD.size:
            if len(data) - at < head + HEAD.size:
                return 0
            kind, _, sent = HEAD.unpack_from(data, at + head)
            self._sent = sent if kind == PICTURE else 0.0
        else:
            self._sent = 0.0
        self._left = size
        return head

    def connection_lost(self, exc: Exception | None) -> None:
        """Count those that the server has cut off."""
        self.crowd.lost += 1
        if not self.joined.done():
            self.joined.set_exception(exc or ConnectionError("the server closed the connection"))


class Crowd:
    """The viewers, and what they have noted."""

    def __init__(self, url: str) -> None:
        parts = urlsplit(url)
        self.host, self.port = parts.hostname or "127.0.0.1", parts.port or 80
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

    async def join(self) -> None:
        """Add one more viewer. Raises OSError if it is refused."""
        loop = asyncio.get_running_loop()
        _, viewer = await loop.create_connection(lambda: Viewer(self), self.host, self.port)
        self.viewers.append(viewer)
        await viewer.joined

    def leave(self) -> None:
        """Remove the viewer that came first."""
        self.viewers.pop(0).transport.abort()
        self.lost -= 1  # it was not lost

    async def watch(self, seconds: float, changes: float = 0.0) -> dict[str, float]:
        """Watch for a while; return what was seen. With changes only the delays of the last minute are kept."""
        self.delays.clear()
        self.noting, begun = True, time.monotonic()
        while changes and time.monotonic() - begun < seconds - LAST_S:
            self.leave()
            await asyncio.gather(self.join(), asyncio.sleep(1 / changes))
            if len(self.delays) > MANY:
                self.delays.clear()
        await asyncio.sleep(max(0.0, begun + seconds - time.monotonic()))
        self.noting, took = False, time.monotonic() - begun
        delays = sorted(self.delays)
        without = sum(viewer.last < begun for viewer in self.viewers)
        if not delays:
            raise RuntimeError("no picture came")
        return {
            "pictures": len(delays),
            "wanted": len(self.viewers) * took / EVERY_S,
            "seconds": took,
            "median_ms": delays[len(delays) // 2] * 1000,
            "p99_ms": delays[int(0.99 * len(delays))] * 1000,
            "most_ms": delays[-1] * 1000,
            "without": without,
            "lost": self.lost,
        }


async def run(url: str, viewers: int, seconds: float, changes: float) -> None:
    """Have them join, then watch."""
    crowd = Crowd(url)
    for many in (FIRST, viewers):
        while len(crowd.viewers) < many:
            await asyncio.gather(*(crowd.join() for _ in range(min(AT_ONCE, many - len(crowd.viewers)))))
        await asyncio.sleep(SETTLE_S)
        await told({"joined": len(crowd.viewers)})
    await told(await crowd.watch(seconds, changes))


async def told(what: dict[str, float]) -> None:
    """Print a line and wait for an answer."""
    print(json.dumps(what), flush=True)
    await asyncio.to_thread(sys.stdin.readline)


if __name__ == "__main__":
    many_files()
    uvloop.run(run(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), float((*sys.argv, "0")[4])))
