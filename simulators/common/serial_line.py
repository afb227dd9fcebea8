"""The serial line: a pty, or a serial server on TCP, limited to its baud rate, with faults on request."""

import contextlib
import select
import socket
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, Protocol

from robots.kit.clock import TIMER, Timer
from robots.kit.files import replace_text
from simulators.common.faults import FaultBoard
from simulators.common.terminal import Terminal

BITS_A_BYTE = 10  # 8 data bits, start and stop bit
TICK_S = 0.003
IDLE_TICK_S = 0.01  # between two looks for bytes while the arm does nothing
IDLE_S = 0.1
MOST_OUT = 4096  # bytes that wait to be sent: more answers would only come too late
AHEAD = 128  # bytes that the line buffers, as a small UART does


class Frame(Protocol):
    """A message on the line."""

    def encode(self) -> bytes:
        """Return its bytes."""


class Arrived(NamedTuple):
    """Bytes, and when the first and the last of them arrived (s, on the simulator's clock)."""

    data: bytes
    since: float
    until: float


class Line:
    """The simulator's end of the line; the other is the terminal at `link`."""

    def __init__(self, link: Path, faults: FaultBoard, baud: int, clock: Timer = TIMER) -> None:
        self._clock = clock
        self._byte_s = BITS_A_BYTE / baud
        self._room = AHEAD + int(4 * TICK_S / self._byte_s)
        self._open(link)
        self._faults = faults
        self._in: deque[tuple[float, int]] = deque()
        self._out: deque[tuple[float, int]] = deque()
        self._in_free = self._out_free = 0.0
        self._more = False

    def _open(self, link: Path) -> None:
        self._terminal = Terminal(link)

    def _listened(self) -> list[int]:
        return [self._terminal.number]

    def _write(self, data: bytes) -> None:
        self._terminal.write(data)

    def _receive(self, most: int) -> bytes:
        try:
            return self._terminal.read(most)
        except OSError:
            return b""

    def send(self, frame: Frame) -> None:
        """Queue a frame; each byte is sent when the baud rate allows it. Where too many wait already, it is lost."""
        if self._faults.value("mute") or len(self._out) > MOST_OUT:
            return
        late = self._faults.value("slow")
        at = max(self._out_free, self._clock.monotonic() + late)
        for byte in self._faults.spoil(frame.encode()):
            at += self._byte_s
            self._out.append((at, byte))
        self._out_free = at

    def wait(self, timeout: float, /) -> bool:
        """Wait for bytes, at most so many real seconds; return whether they came."""
        return bool(select.select(self._listened(), [], [], timeout)[0])

    def poll(self, busy: bool) -> Arrived:
        """Wait a moment; write bytes that are due, return bytes that arrived."""
        carried = max((row[-1][0] for row in (self._in, self._out) if row), default=0.0)
        if carried:
            left = carried - self._clock.monotonic()
            self._clock.sleep(TICK_S if busy else min(max(left, TICK_S), IDLE_TICK_S))
        else:
            self._clock.wait(self, TICK_S if busy else IDLE_S)
        return self.exchange()

    def exchange(self) -> Arrived:
        """Write bytes that are due, return bytes that arrived; do not wait."""
        self._read()
        now = self._clock.monotonic()
        due = bytearray()
        while self._out and self._out[0][0] <= now:
            due.append(self._out.popleft()[1])
        if due:
            self._write(bytes(due))
        arrived, since, until = bytearray(), now, now
        while self._in and self._in[0][0] <= now:
            until, byte = self._in.popleft()
            since = since if arrived else until
            arrived.append(byte)
        return Arrived(bytes(arrived), since, until)

    def _read(self) -> None:
        """Read bytes at the rate of the line; a faster sender has to wait."""
        room = self._room - len(self._in)
        if room <= 0:
            return
        data = self._receive(room)
        at = self._in_free if self._more else max(self._in_free, self._clock.monotonic())
        self._more = len(data) == room  # more bytes were waiting, so the line was not silent
        for byte in self._faults.spoil(data):
            at += self._byte_s
            self._in.append((at, byte))
        self._in_free = at


class TcpLine(Line):
    """The same line behind a serial server: one client at a time, others are refused."""

    def __init__(
        self,
        link: Path,
        faults: FaultBoard,
        baud: int,
        port: int,
        refused: Callable[[], None],
        clock: Timer = TIMER,
    ) -> None:
        self._server = socket.create_server(("127.0.0.1", port))
        self._server.setblocking(False)
        self._client: socket.socket | None = None
        self._refused = refused
        super().__init__(link, faults, baud, clock)

    @property
    def port(self) -> int:
        """Return the port of the server."""
        return int(self._server.getsockname()[1])

    def _open(self, link: Path) -> None:
        link.unlink(missing_ok=True)
        replace_text(link, f"127.0.0.1:{self.port}")

    def _listened(self) -> list[int]:
        return [s.fileno() for s in (self._server, self._client) if s is not None]

    def _accept(self) -> None:
        with contextlib.suppress(BlockingIOError):
            while True:
                client, _ = self._server.accept()
                if self._client is not None:
                    client.close()
                    self._refused()
                    continue
                client.setblocking(False)
                client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._client = client

    def _drop(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None

    def _write(self, data: bytes) -> None:
        try:
            if self._client is not None:
                self._client.sendall(data)
        except OSError:
            self._drop()

    def _receive(self, most: int) -> bytes:
        self._accept()
        if self._client is None:
            return b""
        try:
            data = self._client.recv(most)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self._drop()
        return data


OpenLine = Callable[[Path, FaultBoard, Callable[[], None]], Line]  # the last argument is called for each refused client


def line_opener(baud: int, tcp: int | None, clock: Timer) -> OpenLine:
    """Return what opens a terminal, or a serial server at the port `tcp` (0: any port)."""

    def opened(tty: Path, faults: FaultBoard, refused: Callable[[], None]) -> Line:
        if tcp is None:
            return Line(tty, faults, baud, clock)
        return TcpLine(tty, faults, baud, tcp, refused, clock)

    return opened
