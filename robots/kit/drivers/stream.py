"""The TCP connection under a robot's line; a test gives the line another."""

import select
import socket
from collections.abc import Callable
from typing import Protocol


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
