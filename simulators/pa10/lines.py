"""Reads lines from a connection; a line in memory is never longer than the wire allows."""

from collections.abc import Iterator
from typing import Protocol

from robots.drivers.pa10.protocol import LONGEST

PIECE = 4096


class Line(Protocol):
    """The controller's end of a connection."""

    def receive(self, most: int, /) -> bytes:
        """Wait for bytes and return at most so many; b"" at the end of the connection. Raises OSError."""

    def sendall(self, data: bytes, /) -> None:
        """Send all of it. Raises OSError, also where the client does not read for a while."""

    def shut(self) -> None:
        """End the connection; who waits to receive gets its end. Raises OSError."""

    def close(self) -> None:
        """Give back what the system keeps for it."""


def lines(line: Line) -> Iterator[str]:
    """Yield each line without its end, until the connection ends.

    A line that is too long is cut so that the reader can see this; bytes that are not ASCII become U+FFFD. An
    unfinished line at the end is dropped.

    Raises:
        OSError: the connection was lost.
        EOFError: it was closed; the message says how.
    """
    rest, cut = b"", False
    while data := line.receive(PIECE):
        *whole, last = data.split(b"\n")
        for part in whole:
            yield (rest + part)[: LONGEST + 2].decode("ascii", "replace").rstrip("\r")
            rest, cut = b"", False
        rest = (rest + last)[: LONGEST + 2]
        cut = bool(rest)
    raise EOFError("half a line, then the end" if cut else "the client closed the line")
