"""Lines off a socket, however long or strange: none is longer in memory than the wire allows."""

import socket
from collections.abc import Iterator

from robots.drivers.pa10.protocol import LONGEST

PIECE = 4096


def lines(line: socket.socket) -> Iterator[str]:
    """Give each line without its end, until the connection ends.

    What is longer than the wire allows comes as so much of it that the reader sees that; bytes
    that are no ASCII come as U+FFFD. Half a line at the end is no line.

    Raises:
        OSError: the connection broke.
        EOFError: it ended; the message says how.

    """
    rest, cut = b"", False
    while data := line.recv(PIECE):
        *whole, last = data.split(b"\n")
        for part in whole:
            yield (rest + part)[: LONGEST + 2].decode("ascii", "replace").rstrip("\r")
            rest, cut = b"", False
        rest = (rest + last)[: LONGEST + 2]
        cut = bool(rest)
    raise EOFError("half a line, then the end" if cut else "the client closed the line")
