"""The driver's end of the rover's line: bytes over TCP, or over whatever a test opens in its place."""

from pathlib import Path

from robots.kit.drivers.srv1.protocol import PORT
from robots.kit.drivers.stream import OpenStream, Stream, open_stream

OPEN_S = 2.0  # the longest that opening, or sending, may take


class Wire:
    """Bytes in order, in both directions. One thread may read while others write."""

    def __init__(self, stream: Stream) -> None:
        self._stream = stream

    def write(self, data: bytes) -> None:
        """Send all of it. Raises OSError."""
        self._stream.sendall(data)

    def read(self, most: int, seconds: float) -> bytes:
        """Return at most so many bytes that have come, b"" if none came within so many seconds.

        Raises:
            OSError, ValueError: the other end has closed it, it is broken, or another thread has closed it.

        """
        try:
            data = self._stream.receive(most, seconds)
        except TimeoutError:
            return b""
        if not data:
            raise ConnectionError("the rover's Wi-Fi module has closed the connection")
        return data

    def close(self) -> None:
        """Close it. Raises OSError."""
        self._stream.close()


def where(address: str) -> tuple[str, int]:
    """Return host and port of `host:port`, `socket://host:port`, a host alone, or a file that contains one of these.

    Raises:
        OSError, ValueError: there is no such file, or no port in it.

    """
    text = address.removeprefix("socket://").removeprefix("tcp:")
    if text.startswith("/"):
        text = Path(text).read_text().strip().removeprefix("socket://")
    host, colon, port = text.rpartition(":")
    return (host or "127.0.0.1", int(port)) if colon else (text, PORT)


def open_wire(address: str, opened: OpenStream = open_stream) -> Wire:
    """Connect to the rover. Raises OSError, ValueError."""
    return Wire(opened(*where(address), OPEN_S))
