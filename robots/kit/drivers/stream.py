"""The TCP connection under a robot's line, and what the owner's end of every such line has in common.

A test gives the line another connection.
"""

import contextlib
import select
import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Protocol

from robots.kit.clock import Timer
from robots.kit.contract.errors import LineGone, LineSilent, why
from robots.kit.contract.session import Permit, Trace
from robots.kit.opening import why_not


class Stream(Protocol):
    """Bytes in both directions, in order."""

    def sendall(self, data: bytes, /) -> None:
        """Send all of it. Raises OSError."""

    def receive(self, most: int, seconds: float, /) -> bytes:
        """Return at most so many of the bytes that have come, b"" once the other end has closed.

        Waits until there are any, at most so many seconds.

        Raises:
            TimeoutError: nothing came.
            OSError, ValueError: it is broken; another thread has closed it.
        """

    def close(self) -> None:
        """Close it. Raises OSError."""


OpenStream = Callable[[str, int, float], Stream]  # host, port, the longest that opening or sending may take (s)


class TcpStream:
    """A `Stream` over a socket."""

    def __init__(self, made: socket.socket) -> None:
        self._socket = made
        made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def sendall(self, data: bytes) -> None:
        """See Stream."""
        self._socket.sendall(data)

    def receive(self, most: int, seconds: float) -> bytes:
        """See Stream."""
        arrives = select.poll()
        arrives.register(self._socket, select.POLLIN)
        if not arrives.poll(1000 * seconds):
            raise TimeoutError
        return self._socket.recv(most)

    def close(self) -> None:
        """See Stream."""
        self._socket.close()


def open_stream(host: str, port: int, seconds: float) -> Stream:
    """Connect to a port. Raises OSError, ValueError."""
    made = socket.create_connection((host, port), timeout=seconds)
    try:
        return TcpStream(made)
    except OSError:
        made.close()
        raise


def written_address(address: str) -> str:
    """Return the address, or the one that stands in a file where it is a file's path. Raises OSError, ValueError."""
    return Path(address).read_text().strip() if address.startswith("/") else address


def host_and_port(address: str, port: int | None = None) -> tuple[str, int]:
    """Return host and port of `host:port`, `socket://host:port`, or a file that contains one of these.

    `port` is that of a host alone. Raises OSError, ValueError: there is no such file, or no port.
    """
    text = written_address(address.removeprefix("socket://").removeprefix("tcp:")).removeprefix("socket://")
    host, colon, written = text.rpartition(":")
    return (text, port) if port is not None and not colon else (host or "127.0.0.1", int(written))


class OwnerLine:
    """The owner's end of a line: one exchange at a time, and a hold that is sent even while an answer is awaited.

    `controller` begins sentences for people, `robot` stands within them. `silence` are the errors that count as
    silence: no answer, or one that cannot be read.
    """

    controller: str
    robot: str
    silence: tuple[type[Exception], ...] = (TimeoutError,)

    def __init__(self, address: str, trace: Trace | None, clock: Timer, opened: OpenStream) -> None:
        self._address, self._trace, self._clock, self._opened = address, trace, clock, opened
        self._stream: Stream | None = None
        self._lock = clock.lock()  # for one exchange
        self._writing = clock.lock()  # for one message, so that a hold can be sent within an exchange

    @property
    def is_open(self) -> bool:
        """Return whether a connection is open."""
        return self._stream is not None

    def close(self) -> None:
        """Close the connection."""
        with self._lock:
            self._close()

    def _close(self) -> None:
        if self._stream is not None:
            with contextlib.suppress(OSError):
                self._stream.close()
        self._stream = None

    def _connect(self, seconds: float, port: int | None = None) -> None:
        """Close the connection and open a new one. Raises LineGone."""
        self._close()
        try:
            self._stream = self._opened(*host_and_port(self._address, port), seconds)
        except (OSError, ValueError) as error:
            self._close()
            raise LineGone(f"{self.controller} cannot be reached: {why_not(error)}") from error

    def _open_line(self) -> Stream:
        if self._stream is None:
            raise LineGone(f"{self.controller} is not connected.")
        return self._stream

    def _send(self, data: bytes, permit: Permit | None) -> None:
        with self._writing:
            if permit is not None:
                permit()  # last before actuation
            self._open_line().sendall(data)

    def _fell_silent(self) -> None:
        """Close the connection: an answer that comes later must not be taken for the next one."""
        self._close()

    @contextlib.contextmanager
    def _watched(self) -> Iterator[None]:
        """Translate errors on the wire. The connection is closed; after silence `_fell_silent` decides."""
        try:
            yield
        except self.silence as error:
            self._fell_silent()
            raise LineSilent(f"{self.controller} does not answer.") from error
        except (OSError, ValueError) as error:  # the latter: another thread has closed the connection
            self._close()
            raise LineGone(f"The connection to {self.robot} broke: {why(error)}.") from error
