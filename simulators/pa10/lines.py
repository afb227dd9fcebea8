"""Reads lines from a connection; a line in memory is never longer than the wire allows."""

from collections.abc import Iterator

from robots.kit.drivers.pa10.protocol import LONGEST
from simulators.common.tcp import Line

PIECE = 4096


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
