"""How many bytes may be on the way to a peer behind a thin line, so that what is urgent does not wait behind them.

The line is measured end to end: WebSocket's pings, which every browser answers in order, follow the messages. TCP's own
acknowledgements (TCP_INFO, TIOCOUTQ) come from the next proxy, not from the peer, and that a transport has taken
everything says only that it lies in a buffer of the system. So many bytes may be on the way that an answer takes at
most 0.3 s longer than over the empty line: 0.3 s of what the line carries, beside what a long line holds by itself.
The window grows and shrinks by that delay, as that of TCP Vegas (Brakmo and Peterson 1995). Pure; times are of a
monotonic clock (s).
"""

import struct
from collections import deque
from collections.abc import Callable
from math import inf
from typing import Any, NamedTuple

MOST_S = 0.3  # a message may wait for others so long on its way
LEAST, FIRST, MOST = 32, 256, 1 << 20  # bytes that may be on the way: about one small message; until something is known
PINGS = 3  # in a window
PAYLOAD = struct.Struct(">H")
PING_BYTES = 4


class _Ping(NamedTuple):
    """A ping: its number, the bytes written until its end, when it was sent, how many were on the way then."""

    number: int
    position: int
    sent_at: float
    ahead: int


class SendWindow:
    """The bytes that were written to a peer, those that it has acknowledged, and how many of them may be on the way."""

    def __init__(self) -> None:
        self.size = FIRST
        self._written = self._acked = 0
        self._pings: deque[_Ping] = deque()
        self._number = self._pinged = 0  # of the newest ping: its number, the bytes until its end
        self._empty_s = inf  # what an answer takes over the empty line
        self._judged_from = 0  # pings from this position on were sent after the window was made smaller

    @property
    def on_the_way(self) -> int:
        """Return how many bytes are on the way, as far as is known."""
        return self._written - self._acked

    @property
    def full(self) -> bool:
        """Return whether nothing more should be written now but what is urgent."""
        return self.on_the_way >= self.size

    def wrote(self, size: int, now: float) -> bytes | None:
        """Count so many bytes; return the payload of a ping that has to follow them, None if none has."""
        self._written += size
        return self._due(now)

    def _due(self, now: float) -> bytes | None:
        unpinged = self._written - self._pinged
        if not unpinged or (unpinged < self.size / PINGS and (self._pings or not self.full)):
            return None
        self._number = (self._number + 1) % 65536
        self._written += PING_BYTES
        self._pinged = self._written
        self._pings.append(_Ping(self._number, self._written, now, self.on_the_way))
        return PAYLOAD.pack(self._number)

    def pong(self, payload: bytes, now: float) -> bytes | None:
        """Take an answer to a ping, and to all before it; return the payload of a ping that has to follow now.

        Any other payload is ignored.
        """
        number = PAYLOAD.unpack(payload)[0] if len(payload) == PAYLOAD.size else None
        if all(ping.number != number for ping in self._pings):
            return None
        while (ping := self._pings.popleft()).number != number:
            pass
        self._judge(ping, now - ping.sent_at, ping.position - self._acked)
        self._acked = ping.position
        return self._due(now)

    def _judge(self, ping: _Ping, took_s: float, carried: int) -> None:
        """Make the window larger or smaller: a ping was answered after `took_s`; so many bytes more have arrived."""
        if self.size == LEAST:  # with less nothing can be tried: the line has become slower, or longer
            self._empty_s = took_s
        self._empty_s = min(self._empty_s, took_s)
        waited = took_s - self._empty_s
        if waited > MOST_S:
            if ping.position > self._judged_from:  # else it was sent before the last time
                self.size = max(LEAST, int(min(self.size, ping.ahead) * max(0.25, MOST_S / waited)))
                self._judged_from = self._written
        elif ping.ahead >= self.size / 2 and waited < MOST_S / 2:
            self.size = min(MOST, self.size + (carried if waited < MOST_S / 6 else carried // 8))


class CountedTransport:
    """A transport whose written bytes are counted, whoever writes them."""

    def __init__(self, transport: Any, wrote: Callable[[int], None]) -> None:
        self.transport, self._wrote = transport, wrote

    def __getattr__(self, name: str) -> Any:
        return getattr(self.transport, name)

    def write(self, data: bytes) -> None:
        """Write, then count."""
        self.transport.write(data)
        self._wrote(len(data))
