"""One connection to the museum arm's controller: one thread reads, one answers in order.

Reading never waits for an answer, so a hold is received whatever stands before it, and the end of the connection is
noticed at once.
"""

import contextlib
import threading
from collections import deque
from collections.abc import Callable
from functools import partial

from robots.kit.arms.planner import Refused
from robots.kit.clock import TIMER, Timer, Until
from robots.kit.drivers.pa10.protocol import Malformed
from simulators.common.faults import FaultBoard
from simulators.common.journal import Note
from simulators.common.tcp import Line

MOST_WAITING = 1000  # lines in the queue; a longer queue is refused
LOOK_S = 3600.0  # between two looks into an empty queue; a new order wakes the thread sooner
Order = Callable[[], str]


class Client:
    """A connected client. `owner`: it has claimed the arm with `i`, so silence counts."""

    def __init__(self, line: Line, peer: str, faults: FaultBoard, note: Note, clock: Timer = TIMER) -> None:
        self.line, self.peer, self._faults, self._note, self._clock = line, peer, faults, note, clock
        self.epoch, self.owner, self.heard_at = 0, False, self._clock.monotonic()
        self._row: deque[Order] = deque()
        self._changed = threading.Condition()
        self._answering, self._waits, self._closed = False, 0, False
        self._writing = threading.Lock()

    @property
    def silent_s(self) -> float:
        """Return for how long an owner has been silent (s); a client that waits or types is not silent."""
        with self._changed:
            waits = self._waits or self._row or self._answering
        return 0.0 if waits or not self.owner else self._clock.monotonic() - self.heard_at

    def begin(self) -> None:
        """Start to answer lines."""
        self._clock.spawn(self._answer, "client")

    def put(self, order: Order) -> None:
        """Put an order into the queue."""
        with self._changed:
            full = len(self._row) >= MOST_WAITING
            if not full:
                self._row.append(order)
                self._changed.notify()
        if full:
            self.say(f"e busy {MOST_WAITING} lines wait for their answers already")

    def wait(self, rest: Callable[[], str]) -> str:
        """Answer `W` when the arm rests; all `W` of a client share one thread."""
        with self._changed:
            if self._waits == 0:
                self._clock.spawn(partial(self._wait, rest), "wait")
            self._waits += 1
        return ""

    def _wait(self, rest: Callable[[], str]) -> None:
        letter = rest()
        with self._changed:
            count, self._waits = self._waits, 0
        self.heard_at = self._clock.monotonic()
        for _ in range(count):
            self.say(letter)

    def _answer(self) -> None:
        while True:
            with self._changed:
                self._answering = False
                while not self._clock.wait(Until(self._changed, lambda: self._row or self._closed), LOOK_S):
                    pass
                if self._closed:
                    return
                order, self._answering = self._row.popleft(), True
            if answer := self.answer_of(order):
                self.say(answer)
            self.heard_at = self._clock.monotonic()

    def answer_of(self, order: Order) -> str:
        """Return the answer, or why the order is refused; after any error the client is still served."""
        try:
            return order()
        except Malformed as error:
            return f"e {error.code} {error}"
        except Refused as error:
            return f"e {error.code} {error}"
        except Exception as error:  # noqa: BLE001 - one line must not end the others' service
            self._note("crash", error=f"{type(error).__name__}: {error}")
            return "e busy the controller failed at this line"

    def say(self, text: str) -> None:
        """Send a line; a client that does not read for a while is disconnected."""
        if self._faults.value("mute") or self._faults.value("awol"):
            return
        if self._faults.value("slow"):
            self._clock.sleep(self._faults.value("slow"))
        try:
            with self._writing:
                self.line.sendall(text.replace("°", " deg").encode("ascii", "replace") + b"\n")
        except OSError:
            self.shut()

    def shut(self) -> None:
        """End the connection; the reader notices."""
        with self._changed:
            self._closed = True
            self._row.clear()
            self._changed.notify_all()
        with contextlib.suppress(OSError):
            self.line.shut()

    def close(self) -> None:
        """Close the socket; called last, by the reader."""
        self.shut()
        self.line.close()
