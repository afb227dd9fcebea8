"""The host's end of a serial line on which each instruction has a number: sends, waits for the answer, resends.

What the bytes mean is the robot's own `protocol` module.

After a wrong checksum or silence the same bytes are sent again under the same sequence number, at most ten times. A
hold overtakes: after it, no motion that was started before is sent again.
"""

import contextlib
import logging
import os
import socket
import termios
import threading
from collections.abc import Callable
from typing import Generic, Literal, Protocol, TypeVar

import serial

from robots.kit.clock import TIMER, Limit, Timer, Until
from robots.kit.contract.errors import (
    ControllerRefused,
    ControllerRestarted,
    HardwareFault,
    LineBusy,
    LineGone,
    LineSilent,
    MotionHeld,
)
from robots.kit.contract.session import Permit, Trace
from robots.kit.opening import is_in_use, why_not

log = logging.getLogger(__name__)
ANSWER_S = 0.30  # a question, a state reply on its way, an answer, and a margin
HOLD_ANSWER_S = 0.20
READ_S, READ_OVER_NET_S = 1.0, 0.05  # a reader waits so long for a byte; only that of a local port can be woken
REOPEN_S = 60.0  # a port is opened again after so long a silence, and not before
UNACKNOWLEDGED_MS = 5000  # a TCP connection whose other machine acknowledges no byte for so long ends
GONE = "The robot's serial line is gone; the cable may be unplugged."
Kind = Literal["answer", "end", "state", "resend", "other"]
T = TypeVar("T")


class Frame(Protocol):
    """One message: its code, its sequence number (0 to 255), and its bytes."""

    @property
    def id(self) -> int:
        """Return the code."""

    @property
    def seq(self) -> int:
        """Return the number that an answer repeats."""

    def encode(self) -> bytes:
        """Return the bytes on the line."""


class BootState(Protocol):
    """The state of a controller."""

    @property
    def boot(self) -> int:
        """Return the number of its start."""


F = TypeVar("F", bound=Frame)
S = TypeVar("S", bound=BootState, covariant=True)


class Receiver(Protocol[F]):
    """Finds frames in a stream of bytes."""

    broken: int

    def feed(self, data: bytes, at: float, /) -> list[F]:
        """Return the frames that `data`, received at `at` (s), completes."""


class Wire(Protocol[F, S]):
    """A `protocol` module, as the line needs it."""

    HOLD: int
    RESET: int

    def receiver(self) -> Receiver[F]:
        """Return a receiver of replies."""

    def status(self, seq: int, /) -> F:
        """Return the question for the state."""

    def kind_of(self, reply: F, /) -> Kind:
        """Return what a reply is: an answer, the end of a motion, a state, or the request to send again.

        Raises ValueError: it has impossible numbers.
        """

    def state_of(self, reply: F, /) -> S:
        """Return the state in a reply."""

    def boot_of(self, reply: F, /) -> int:
        """Return the number of the controller's start."""

    def refusal_of(self, answer: F, /) -> str:
        """Return why an answer refuses, empty if it does not."""

    def spell(self, frame: F, /) -> str:
        """Return a frame as text."""


def _keep_ready(port: serial.SerialBase) -> None:
    """Leave the signal DTR on when the port is closed: its change at the next opening resets many controllers."""
    with contextlib.suppress(Exception):  # a port without it
        attributes = termios.tcgetattr(port.fileno())
        attributes[2] &= ~termios.HUPCL
        termios.tcsetattr(port.fileno(), termios.TCSANOW, attributes)


def _end_unacknowledged(port: serial.SerialBase) -> None:
    """Let a TCP connection end if its other machine is gone; a controller that is only silent does not end it."""
    with contextlib.suppress(Exception), socket.socket(fileno=os.dup(port.fileno())) as same:  # not every system has it
        same.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, UNACKNOWLEDGED_MS)


def open_port(url: str, local: bool, baud: int) -> serial.SerialBase:
    """Open a port of this machine (`local`), exclusively, or one behind a network."""
    return serial.serial_for_url(
        url, baudrate=baud, timeout=READ_S if local else READ_OVER_NET_S, write_timeout=1.0,
        **({"exclusive": True} if local else {}),
    )  # fmt: skip


OpenPort = Callable[[str, bool, int], serial.SerialBase]


class SerialLine(Generic[F, S]):
    """A serial port with a reader thread; frames are matched by sequence number."""

    def __init__(
        self, wire: Wire[F, S], url: str, baud: int, resends: int, trace: Trace | None, clock: Timer = TIMER,
        opened: OpenPort = open_port,
    ) -> None:  # fmt: skip
        self._wire, self._baud = wire, baud
        self._url, self._resends, self._trace, self._clock, self._opened = url, resends, trace, clock, opened
        self._local = "://" not in url
        self._heard_at = 0.0  # on its clock (s); or when the port was opened
        self._port: serial.SerialBase | None = None
        self._write_lock = clock.lock()
        self._news, self._told = threading.Condition(), 0
        self._replies: dict[int, F] = {}
        self._ends: dict[int, F] = {}
        self._states: dict[int, S] = {}
        self.newest: tuple[F, float] | None = None  # the newest reply, and when it came, on the line's clock (s)
        self._spoilt: set[int] = set()  # sequence numbers that arrived with a wrong checksum
        self._seq = self._poll_seq = 0
        self._holds = self._malformed = 0
        self._gone: str | None = None
        self._reader: threading.Thread | None = None
        self.boot: int | None = None
        self.resent = 0
        self.broken = 0

    def open(self) -> None:
        """Open the port exclusively. Raises LineBusy, LineGone.

        A port that is open stays so, unless it has been silent for long: many controllers boot whenever their port is
        opened, also by a serial server at each connection, and one that needs longer for it than its host waits would
        never answer.
        """
        if self._in_order and self._clock.monotonic() - self._heard_at < REOPEN_S:
            return
        self.close()
        try:
            self._port = self._opened(self._url, self._local, self._baud)
        except Exception as error:  # also termios.error, of an adapter that vanishes while it is opened
            fault = LineBusy if self._local and is_in_use(error) else LineGone
            named = "serial port" if self._local else "line"
            told = why_not(error, self._url if self._local else "")
            raise fault(f"The robot's {named} cannot be opened: {told}") from error
        (_keep_ready if self._local else _end_unacknowledged)(self._port)
        self._gone, self._heard_at = None, self._clock.monotonic()
        # raises where the system has no thread left; the port is closed before the next attempt
        self._reader = self._clock.spawn(self._read, "line")

    def reach(self) -> None:
        """Ask for the state, of whichever start; open the port where no answer comes. Raises as `open`."""
        try:
            self.boot = None
            self.status()
        except HardwareFault:
            self.open()

    @property
    def _in_order(self) -> bool:
        reads = self._reader is not None and self._reader.is_alive()
        return self._port is not None and self._gone is None and reads

    def close(self) -> None:
        """Close the port; waiting threads are told."""
        self._lose("closed")
        if self._port is not None:
            with contextlib.suppress(Exception):  # not over the network
                self._port.cancel_read()
        if self._reader is not None and self._reader is not threading.current_thread():
            self._reader.join(1.0)
        if self._port is not None:
            with contextlib.suppress(Exception):
                self._port.close()
        self._port = None

    def start_after(self, seq: int) -> None:
        """Continue counting after the controller's newest sequence number."""
        self._seq = seq

    @property
    def holds(self) -> int:
        """The number of holds so far; a motion compares it with the number at its start."""
        return self._holds

    def _read(self) -> None:
        """Receive until the line is lost; the end of this thread marks it as lost, so that no thread waits on."""
        receiver = self._wire.receiver()
        try:
            while self._gone is None and (port := self._port) is not None:
                data = port.read(max(1, port.in_waiting))
                for frame in receiver.feed(data, self._clock.monotonic()) if data else ():
                    self._heard(frame)
                self.broken = receiver.broken + self._malformed
        except (serial.SerialException, OSError, TypeError) as error:  # the port has gone
            self._lose(str(error))
        except Exception as error:
            log.exception("the reader of the line failed")
            self._lose(str(error))

    def _lose(self, why: str) -> None:
        with self._news:
            self._gone = self._gone or why
            self._tell()

    def _tell(self) -> None:
        """Wake the threads that wait for news; the caller holds the lock."""
        self._told += 1
        self._news.notify_all()

    def _await_news(self, seconds: float) -> None:
        """Wait for the next news, at most so many seconds; the caller holds the lock."""
        told = self._told
        self._clock.wait(Until(self._news, lambda: self._told != told), seconds)

    def _heard(self, frame: F) -> None:
        """Receive one reply; one that does not fit its code or has impossible numbers is dropped."""
        try:
            kind = self._wire.kind_of(frame)
            state = self._wire.state_of(frame) if kind == "state" else None
        except ValueError:
            self._malformed += 1
            return
        if kind == "other":
            return
        if self._trace:
            self._trace("<", frame.encode(), self._wire.spell(frame))
        self._heard_at = self._clock.monotonic()
        with self._news:
            self.newest = frame, self._heard_at
            if state is not None:
                self._states[frame.seq] = state
            elif kind == "end":
                self._ends[frame.seq] = frame
            elif kind == "resend":
                self._spoilt.add(frame.seq)
            else:
                self._replies[frame.seq] = frame
            self._tell()

    def _send(self, frame: F, permit: Permit | None) -> None:
        with self._write_lock:
            if permit is not None:
                permit()  # last before actuation
            port = self._port
            if port is None or self._gone is not None:
                raise LineGone(GONE)
            try:
                port.write(frame.encode())
            except Exception as error:  # also termios.error
                self._lose(str(error))
                raise LineGone(GONE) from error
        if self._trace:
            self._trace(">", frame.encode(), self._wire.spell(frame))

    def _exchange(
        self,
        frame: F,
        found: Callable[[], T | None],
        permit: Permit | None,
        answer_s: float,
        on_sent: Callable[[], None] | None = None,
    ) -> T:
        """Send until `found` finds the answer: one attempt and ten more.

        A refused checksum leads to the next attempt at once, silence after `answer_s`.
        """
        for attempt in range(self._resends + 1):
            with self._news:
                self._spoilt.discard(frame.seq)
            self._send(frame, permit)
            if attempt == 0 and on_sent:
                on_sent()
            self.resent += attempt > 0
            limit = Limit(self._clock, answer_s)
            with self._news:
                while True:
                    answer = found()
                    if answer is not None:
                        return answer
                    if self._gone is not None:
                        raise LineGone(GONE)
                    left = limit.remaining
                    if left <= 0 or frame.seq in self._spoilt:
                        break
                    self._await_news(left)
        raise LineSilent(f"The robot did not answer {self._resends + 1} tries on its serial line.")

    def instruct(
        self,
        build: Callable[[int], F],
        permit: Permit | None,
        on_sent: Callable[[], None] | None = None,
    ) -> int:
        """Send an instruction until it is acknowledged; return its sequence number.

        Raises:
            MotionHeld: a hold was requested before the acknowledgement.
            ControllerRefused, ControllerRestarted, LineSilent, LineGone: see errors.
        """
        with self._news:
            self._seq = self._seq % 255 + 1
            seq = self._seq
            self._replies.pop(seq, None)
            self._ends.pop(seq, None)
        frame = build(seq)
        hold = frame.id == self._wire.HOLD
        if hold:
            self._holds += 1
        before = self._holds

        def allowed() -> None:
            if not hold and self._holds != before:
                raise MotionHeld("A stop came first.")
            if permit is not None:
                permit()

        def found() -> F | None:
            return self._replies.get(seq) or self._ends.get(seq)

        answer = self._exchange(frame, found, allowed, HOLD_ANSWER_S if hold else ANSWER_S, on_sent)
        self._judge(answer, frame.id == self._wire.RESET)
        return seq

    def _judge(self, answer: F, reset: bool) -> None:
        boot = self._wire.boot_of(answer)
        if reset:
            self.boot = boot
        elif self.boot is not None and boot != self.boot:
            raise ControllerRestarted("The robot's controller has restarted by itself.")
        if why := self._wire.refusal_of(answer):
            raise ControllerRefused(f"The robot's controller refused: {why}.")

    def status(self) -> S:
        """Ask for the state. Raises LineSilent, LineGone, ControllerRestarted."""
        with self._news:
            self._poll_seq = self._poll_seq % 255 + 1
            seq = self._poll_seq
            self._states.pop(seq, None)
        state = self._exchange(self._wire.status(seq), lambda: self._states.get(seq), None, ANSWER_S)
        if self.boot is not None and state.boot != self.boot:
            raise ControllerRestarted("The robot's controller has restarted by itself.")
        return state

    def end_of(self, seq: int, wait_s: float) -> F | None:
        """Wait up to `wait_s` for the end of the motion `seq`; None if it has not come."""
        limit = Limit(self._clock, wait_s)
        with self._news:
            while seq not in self._ends:
                left = limit.remaining
                if left <= 0:
                    return None
                if self._gone is not None:
                    raise LineGone(GONE)
                self._await_news(left)
            return self._ends[seq]
