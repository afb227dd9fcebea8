"""The processor's serial port to the Wi-Fi module: bytes wait while the loop is busy, and an interrupt finds a hold.

The stock firmware polls the port. Bytes that it has not read wait in the Wi-Fi module, by flow control: at most `ROOM`
here; more are lost, as bytes are without flow control. The interrupt is ours.
"""

import threading
from collections import deque
from collections.abc import Callable

from robots.kit.clock import TIMER, Limit, Timer, Until
from robots.kit.drivers.srv1.extension import HOLD

ROOM = 4096
LOOK_S = 3600.0  # between two looks at an empty port; a new byte wakes the reader sooner


class Interrupted(Exception):
    """A hold has arrived, or the processor starts anew: the command that is executed is given up."""


class Stopped(Exception):
    """The simulator ends."""


class Uart:
    """One thread reads, any may feed. `held` is called for each hold, in the thread that feeds; None: stock."""

    def __init__(self, held: Callable[[], None] | None, clock: Timer = TIMER) -> None:
        self._held, self._clock = held, clock
        self._changed = threading.Condition()
        self._waiting: deque[tuple[float, int]] = deque()  # bytes, each with when it arrived
        self._tail = b""  # the newest bytes, in which a hold may have begun
        self._interrupted = self._stopped = False
        self.lost_bytes = 0

    def receive(self, data: bytes) -> None:
        """Take what arrives, at any time."""
        seen, new, self._tail = self._tail + data, len(data), b""
        at = seen.rfind(HOLD) if self._held is not None else -1
        if self._held is not None:
            self._tail = seen[max(at + len(HOLD) if at >= 0 else 0, len(seen) - len(HOLD) + 1) :]
        if at >= 0 and self._held is not None:
            self._held()
            data = seen[at + len(HOLD) :]
        now = self._clock.monotonic()
        with self._changed:
            if at >= 0:
                self._waiting.clear()
                self._interrupted = True
            room = ROOM - len(self._waiting)
            self._waiting.extend((now, byte) for byte in data[:room])
            self.lost_bytes += max(0, len(data) - room)
            if new:
                self._changed.notify_all()

    def interrupt(self, forget: bool = False) -> None:
        """Interrupt the loop's command; `forget`: bytes that wait are lost, too."""
        with self._changed:
            self._interrupted = True
            if forget:
                self._waiting.clear()
                self._tail = b""
            self._changed.notify_all()

    def settle(self) -> bool:
        """Return whether there was an interrupt, and clear it."""
        with self._changed:
            was, self._interrupted = self._interrupted, False
            return was

    def stop(self) -> None:
        """End the loop."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()

    def byte(self, seconds: float | None = None) -> int | None:
        """Wait for the next byte, for ever or so long; None if none came. Raises Interrupted, Stopped."""
        limit = None if seconds is None else Limit(self._clock, seconds)
        while True:
            with self._changed:
                wait_s = LOOK_S if limit is None else max(0.0, limit.remaining)
                self._clock.wait(Until(self._changed, self._comes), wait_s)
                self._check()
                if self._waiting:
                    return self._waiting.popleft()[1]
            if limit is not None and limit.remaining <= 0:
                return None

    def argument(self) -> int:
        """Wait for the next byte for ever, as the firmware's `getch`. Raises Interrupted, Stopped."""
        while (byte := self.byte()) is None:
            pass
        return byte

    def delay(self, seconds: float) -> None:
        """Be busy for so long, reading nothing. Raises Interrupted, Stopped."""
        limit = Limit(self._clock, seconds)
        with self._changed:
            while limit.remaining > 0:
                self._clock.wait(Until(self._changed, self._breaks), limit.remaining)
                self._check()

    def flush(self, until: float) -> None:
        """Drop the bytes that arrived until then (monotonic, s), however late this thread is."""
        with self._changed:
            while self._waiting and self._waiting[0][0] <= until:
                self._waiting.popleft()

    def _breaks(self) -> bool:
        return self._interrupted or self._stopped

    def _comes(self) -> bool:
        return bool(self._waiting) or self._breaks()

    def _check(self) -> None:
        if self._stopped:
            raise Stopped
        if self._interrupted:
            raise Interrupted
