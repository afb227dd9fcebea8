"""The TCP port of a simulated controller, and its end of a connection."""

import socket
import struct
from typing import Protocol

UNREAD_S = 2.0  # longest wait of an answer for a client that does not read; real time, which the network counts
LOST_S = (5, 2, 3)  # TCP keep-alive: first probe, next probes (s), number


class Line(Protocol):
    """The controller's end of a connection."""

    def receive(self, most: int, /) -> bytes:
        """Wait for bytes and return at most so many; b"" at the end of the connection. Raises OSError."""

    def sendall(self, data: bytes, /) -> None:
        """Send all of it. Raises OSError, also where the client does not read for a while."""

    def shut(self) -> None:
        """End the connection; a thread that waits to receive gets its end. Raises OSError."""

    def close(self) -> None:
        """Give its descriptor back to the system."""


class Listener(Protocol):
    """The port to which clients connect."""

    def accept(self) -> tuple[Line, str, str]:
        """Wait for a connection; return its end here, the client's host, and its name. Raises OSError."""

    def close(self) -> None:
        """Let nobody connect any more."""


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
