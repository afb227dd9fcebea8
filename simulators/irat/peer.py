"""One connection to the robot: what it subscribes to, and what waits to be sent to it.

Of each topic only the newest message waits, so a slow reader gets fewer, fresh ones and costs no memory. Answers wait
in order, up to a number; who does not read them is disconnected.
"""

import asyncio
from collections import deque
from dataclasses import dataclass

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from robots.clock import TIMER, Limit, Timer
from simulators.common.faults import FaultBoard

MOST_ANSWERS = 64
# real time, because they protect the machine:
A_SECOND, BURST = 400.0, 400.0  # messages; a faster sender has to wait
UNREAD_S = 5.0  # longest wait of a frame for a client that does not read
LOOK_S = 0.005  # between two looks at the clock


@dataclass
class Subscription:
    """One id's wish for a topic: at most one message every `every_s`."""

    every_s: float
    sent: float = 0.0


class Peer:
    """A client. All methods are called in the network's event loop. `real` is the clock that its rate is judged by."""

    def __init__(self, line: ServerConnection, faults: FaultBoard, clock: Timer = TIMER, real: Timer = TIMER) -> None:
        self.line, self._faults, self._clock, self._real = line, faults, clock, real
        self.name = ":".join(map(str, (line.remote_address or ("?", 0))[:2]))
        self.subscriptions: dict[str, dict[str | int | None, Subscription]] = {}
        self.epoch = 0  # under which it commands
        self.heard = clock.monotonic()
        self._newest: dict[str, str] = {}
        self._answers: deque[str] = deque()
        self._some = asyncio.Event()
        self._room, self._filled = BURST, real.monotonic()

    async def within_rate(self) -> None:
        """Let others have their turn; wait if this client sends too fast."""
        now = self._real.monotonic()
        self._room = min(BURST, self._room + (now - self._filled) * A_SECOND)
        self._filled, self.heard = now, self._clock.monotonic()
        self._room -= 1
        await asyncio.sleep(max(0.0, -self._room / A_SECOND))  # frames that wait already would be read without a pause

    def wants(self, topic: str, now: float) -> bool:
        """Return whether a message of this topic is due; counts it as sent."""
        due = [s for s in self.subscriptions.get(topic, {}).values() if now - s.sent >= s.every_s - 1e-3]
        for subscription in due:
            subscription.sent = now
        return bool(due)

    def show(self, topic: str, frame: str) -> None:
        """Send a topic's newest message in place of an older one that still waits."""
        self._newest[topic] = frame
        self._some.set()

    def answer(self, frame: str) -> None:
        """Send an answer after those that wait."""
        if len(self._answers) >= MOST_ANSWERS:
            self.line.transport.abort()
            return
        self._answers.append(frame)
        self._some.set()

    async def _pause(self, seconds: float) -> None:
        limit = Limit(self._clock, seconds)
        while not limit.over:
            await asyncio.sleep(LOOK_S)

    async def write(self) -> None:
        """Send what waits, answers first, until the connection ends."""
        try:
            while True:
                await self._some.wait()
                self._some.clear()
                while self._answers or self._newest:
                    frame = self._answers.popleft() if self._answers else self._newest.pop(next(iter(self._newest)))
                    if self._faults.value("awol") or self._faults.value("mute"):
                        continue
                    if self._faults.value("slow"):
                        await self._pause(self._faults.value("slow"))
                    async with asyncio.timeout(UNREAD_S):
                        await self.line.send(frame)
        except TimeoutError:
            self.line.transport.abort()
        except ConnectionClosed:
            return
