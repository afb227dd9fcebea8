"""One connection to the museum arm's controller: one thread reads, one answers in order.

Reading never waits for an answer, so a hold is received whatever stands before it, and the end of the connection is
noticed at once.
"""

import contextlib
import socket
import struct
import threading
from collections import deque
from collections.abc import Callable

from robots.clock import TIMER, Timer
from robots.drivers.pa10.protocol import Malformed
from robots.motion.planner import Refused
from simulators.common.faults import FaultBoard

MOST_WAITING = 1000  # lines in the queue; more are refused
UNREAD_S = 2.0  # longest wait of an answer for a client that does not read; real time, which the network counts
LOST_S = (5, 2, 3)  # TCP keep-alive: first probe, next probes (s), number
Order = Callable[[], str]
Note = Callable[..., None]


class Client:
    """A connected client. `owner`: it has claimed the arm with `i`, so silence counts."""

    def __init__(self, line: socket.socket, peer: str, faults: FaultBoard, note: Note, clock: Timer = TIMER) -> None:
        self.line, self.peer, self._faults, self._note, self._clock = line, peer, faults, note, clock
        self.epoch, self.owner, self.heard = 0, False, self._clock.monotonic()
        self._row: deque[Order] = deque()
        self._changed = threading.Condition()
        self._answering, self._waits, self._closed = False, 0, False
        self._writing = threading.Lock()
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        line.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, struct.pack("ll", int(UNREAD_S), 0))
        line.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for name, value in zip(("TCP_KEEPIDLE", "TCP_KEEPINTVL", "TCP_KEEPCNT"), LOST_S, strict=True):
            if hasattr(socket, name):
                line.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)

    @property
    def silent_s(self) -> float:
        """Return for how long an owner has been silent (s); a client that waits or types is not silent."""
        with self._changed:
            waits = self._waits or self._row or self._answering
        return 0.0 if waits or not self.owner else self._clock.monotonic() - self.heard

    def begin(self) -> None:
        """Start to answer lines."""
        threading.Thread(target=self._answer, name="client", daemon=True).start()

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
        """Answer `W` when the arm rests; many of them share a thread."""
        with self._changed:
            if self._waits == 0:
                threading.Thread(target=self._wait, args=(rest,), name="wait", daemon=True).start()
            self._waits += 1
        return ""

    def _wait(self, rest: Callable[[], str]) -> None:
        letter = rest()
        with self._changed:
            count, self._waits = self._waits, 0
        self.heard = self._clock.monotonic()
        for _ in range(count):
            self.say(letter)

    def _answer(self) -> None:
        while True:
            with self._changed:
                self._answering = False
                while not self._row and not self._closed:
                    self._changed.wait()
                if self._closed:
                    return
                order, self._answering = self._row.popleft(), True
            if answer := self.answer_of(order):
                self.say(answer)
            self.heard = self._clock.monotonic()

    def answer_of(self, order: Order) -> str:
        """Return the answer, or why it is refused; after any error the client is still served."""
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
        """Send a line; a client that does not read for a while is cut off."""
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
            self.line.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Close the socket; called last, by the reader."""
        self.shut()
        self.line.close()
