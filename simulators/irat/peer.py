"""One connection to the robot: its subscriptions, and the messages that wait to be sent to it.

The messages of a topic are coalesced: only the newest waits, so a slow reader gets fewer and fresh ones and costs no
memory. Answers wait in order, up to a number; a client that does not read them is disconnected.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from robots.kit.clock import TIMER, Timer
from simulators.common.faults import FaultBoard

MOST_ANSWERS = 64


@dataclass
class Subscription:
    """A subscription to a topic under one id: at most one message every `every_s`."""

    every_s: float
    sent_at: float = 0.0


class Peer:
    """A client, however it is connected. Not for several threads.

    `some` is called when a frame waits to be sent, `cut` ends the connection at once.
    """

    def __init__(
        self, name: str, faults: FaultBoard, some: Callable[[], object], cut: Callable[[], object], clock: Timer = TIMER
    ) -> None:
        self.name, self._faults, self._some, self.cut, self._clock = name, faults, some, cut, clock
        self.subscriptions: dict[str, dict[str | int | None, Subscription]] = {}
        self.epoch = 0  # under which it commands
        self.heard_at = clock.monotonic()
        self._newest: dict[str, str] = {}
        self._answers: deque[str] = deque()

    def wants(self, topic: str, now: float) -> bool:
        """Return whether a message of this topic is due; it counts as sent then."""
        due = [s for s in self.subscriptions.get(topic, {}).values() if now - s.sent_at >= s.every_s - 1e-3]
        for subscription in due:
            subscription.sent_at = now
        return bool(due)

    def show(self, topic: str, frame: str) -> None:
        """Send a topic's newest message; it replaces one that still waits."""
        self._newest[topic] = frame
        self._some()

    def answer(self, frame: str) -> None:
        """Send an answer after those that wait."""
        if len(self._answers) >= MOST_ANSWERS:
            self.cut()
            return
        self._answers.append(frame)
        self._some()

    def next(self) -> str | None:
        """Take the next frame to be sent, answers first; None if nothing waits. Faults may lose frames."""
        while self._answers or self._newest:
            frame = self._answers.popleft() if self._answers else self._newest.pop(next(iter(self._newest)))
            if not (self._faults.value("awol") or self._faults.value("mute")):
                return frame
        return None

    @property
    def waits(self) -> bool:
        """Return whether something waits to be sent."""
        return bool(self._answers or self._newest)

    @property
    def slow_s(self) -> float:
        """Return the delay of each frame (s) that the fault board asks for."""
        return self._faults.value("slow")
