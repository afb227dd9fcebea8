"""A client behind a WebSocket: how fast it may send, and how long a frame waits for it."""

import asyncio

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from robots.kit.clock import TIMER, Limit, Timer
from simulators.common.faults import FaultBoard
from simulators.irat.peer import Peer

# real time, because they protect the machine:
A_SECOND, BURST = 400.0, 400.0  # messages; a faster sender has to wait
UNREAD_S = 5.0  # longest wait of a frame for a client that does not read
LOOK_S = 0.005  # between two looks at the clock


class SocketPeer(Peer):
    """All methods are called in the network's event loop. `real` is the clock that its rate is judged by."""

    def __init__(self, line: ServerConnection, faults: FaultBoard, clock: Timer = TIMER, real: Timer = TIMER) -> None:
        self.line, self._real, self._ready = line, real, asyncio.Event()
        name = ":".join(map(str, (line.remote_address or ("?", 0))[:2]))
        super().__init__(name, faults, self._ready.set, line.transport.abort, clock)
        self._room, self._filled = BURST, real.monotonic()

    async def within_rate(self) -> None:
        """Let others have their turn; wait if this client sends too fast."""
        now = self._real.monotonic()
        self._room = min(BURST, self._room + (now - self._filled) * A_SECOND)
        self._filled, self.heard_at = now, self._clock.monotonic()
        self._room -= 1
        await asyncio.sleep(max(0.0, -self._room / A_SECOND))  # frames that wait already would be read without a pause

    async def _pause(self, seconds: float) -> None:
        limit = Limit(self._clock, seconds)
        while not limit.over:
            await asyncio.sleep(LOOK_S)

    async def write(self) -> None:
        """Send what waits until the connection ends."""
        try:
            while True:
                await self._ready.wait()
                self._ready.clear()
                while (frame := self.next()) is not None:
                    if self.slow_s:
                        await self._pause(self.slow_s)
                    async with asyncio.timeout(UNREAD_S):
                        await self.line.send(frame)
        except TimeoutError:
            self.cut()
        except ConnectionClosed:
            return
