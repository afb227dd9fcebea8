"""How many bytes a peer has still to take."""

import fcntl
import struct
import termios
from contextlib import suppress
from typing import Any


def unsent(transport: Any) -> int:
    """Return how many bytes were not acknowledged: those that wait here, and those that the system has taken over.

    The system takes over megabytes, and more of them only after a third of these has gone. So what waits here may
    stay the same for minutes though the peer reads all the time.
    """
    waits: int = transport.get_write_buffer_size()
    line = transport.get_extra_info("socket")
    with suppress(OSError, ValueError, AttributeError):  # closed, or a system that does not tell
        waits += struct.unpack("i", fcntl.ioctl(line.fileno(), termios.TIOCOUTQ, b"\0\0\0\0"))[0]
    return waits
