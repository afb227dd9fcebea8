"""The TCP port of a simulated controller, its end of a connection, and the loop that accepts clients."""

import socket
import struct
from abc import ABC, abstractmethod
from functools import partial
from typing import Protocol

from robots.kit.clock import TIMER, Timer

UNREAD_S = 2.0  # longest wait of an answer for a client that does not read, in real time
LOST_S = (5, 2, 3)  # TCP keep-alive: silence before the first probe (s), between two probes (s), number of probes
AGAIN_S = 0.05  # after a connection that could not be accepted


class Line(Protocol):
    """The controller's end of a connection."""

    def receive(self, most: int, /) -> bytes:
        """Wait for bytes and return at most so many; b"" at the end of the connection. Raises OSError."""

    def sendall(self, data: bytes, /) -> None:
        """Send all of it. Raises OSError, also where the client does not read for a while."""

    def shut(self) -> None:
        """End the connection; a thread that waits to receive gets its end. Raises OSError."""

    def close(self) -> None:
        """Close its descriptor."""


class Listener(Protocol):
    """The port to which clients connect."""

    def accept(self) -> tuple[Line, str, str]:
        """Wait for a connection; return its end here, the client's host, and its name. Raises OSError."""

    def close(self) -> None:
        """Accept no more connections."""


class TcpLine:
    """A connection's end; see `Line`."""

    def __init__(self, line: socket.socket) -> None:
        self._line = line
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        line.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, struct.pack("ll", int(UNREAD_S), 0))
        line.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for name, value in zip(("TCP_KEEPIDLE", "TCP_KEEPINTVL", "TCP_KEEPCNT"), LOST_S, strict=True):
            if hasattr(socket, name):
                line.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)

    def receive(self, most: int) -> bytes:
        """See `Line`."""
        return self._line.recv(most)

    def sendall(self, data: bytes) -> None:
        """See `Line`."""
        self._line.sendall(data)

    def shut(self) -> None:
        """See `Line`."""
        self._line.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """See `Line`."""
        self._line.close()


class TcpListener:
    """Listens on a port of this machine (0: any); see `Listener`."""

    def __init__(self, port: int) -> None:
        self._server = socket.create_server(("127.0.0.1", port))
        self.port = int(self._server.getsockname()[1])

    def accept(self) -> tuple[TcpLine, str, str]:
        """See `Listener`."""
        line, (host, port, *_) = self._server.accept()
        return TcpLine(line), host, f"{host}:{port}"

    def close(self) -> None:
        """See `Listener`."""
        self._server.close()


class Server(ABC):
    """Accepts clients in a thread of `clock`."""

    def __init__(self, clock: Timer = TIMER) -> None:
        self._clock, self._open = clock, True
        self._listener: Listener | None = None

    def listen(self, listener: Listener) -> None:
        """Let clients connect."""
        self._listener = listener
        self._clock.spawn(partial(self._listen, listener), "network")

    def close(self) -> None:
        """Accept no more connections."""
        self._open = False
        if self._listener is not None:
            self._listener.close()

    def _listen(self, listener: Listener) -> None:
        while self._open:
            try:
                line, host, name = listener.accept()
            except OSError:
                self._clock.sleep(AGAIN_S)  # closed, or no descriptors left for now
            else:
                self._accept(line, host, name)

    @abstractmethod
    def _accept(self, line: Line, host: str, name: str) -> None:
        """Begin to serve a client in a thread of its own, or turn it away."""
