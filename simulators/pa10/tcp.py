"""Where the museum arm's controller listens, and its end of a connection."""

import socket
import struct

UNREAD_S = 2.0  # longest wait of an answer for a client that does not read; real time, which the network counts
LOST_S = (5, 2, 3)  # TCP keep-alive: first probe, next probes (s), number


class TcpLine:
    """A connection's end; see `lines.Line`."""

    def __init__(self, line: socket.socket) -> None:
        self._line = line
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        line.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, struct.pack("ll", int(UNREAD_S), 0))
        line.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for name, value in zip(("TCP_KEEPIDLE", "TCP_KEEPINTVL", "TCP_KEEPCNT"), LOST_S, strict=True):
            if hasattr(socket, name):
                line.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)

    def receive(self, most: int) -> bytes:
        """See `lines.Line`."""
        return self._line.recv(most)

    def sendall(self, data: bytes) -> None:
        """See `lines.Line`."""
        self._line.sendall(data)

    def shut(self) -> None:
        """See `lines.Line`."""
        self._line.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """See `lines.Line`."""
        self._line.close()


class TcpListener:
    """Listens on a port of this machine (0: any); see `server.Listener`."""

    def __init__(self, port: int) -> None:
        self._server = socket.create_server(("127.0.0.1", port))
        self.port = int(self._server.getsockname()[1])

    def accept(self) -> tuple[TcpLine, str, str]:
        """See `server.Listener`."""
        line, (host, port, *_) = self._server.accept()
        return TcpLine(line), host, f"{host}:{port}"

    def close(self) -> None:
        """See `server.Listener`."""
        self._server.close()
