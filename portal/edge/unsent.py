"""Counts the bytes that a peer has not read yet, and ends the connection of a peer that does not read."""

import asyncio
import fcntl
import struct
import termios
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from django.conf import settings


def unsent(transport: Any) -> int:
    """Return how many bytes were not acknowledged: those that wait here, and those in the buffer of the system.

    That buffer takes megabytes, and more only after a third of them has gone. So the number that waits here may stay
    the same for minutes though the peer reads all the time.
    """
    waits: int = transport.get_write_buffer_size()
    line = transport.get_extra_info("socket")
    with suppress(OSError, ValueError, AttributeError):  # closed, or a system without this call
        waits += struct.unpack("i", fcntl.ioctl(line.fileno(), termios.TIOCOUTQ, b"\0\0\0\0"))[0]
    return waits


class Unread:
    """Bytes that wait for a peer; its connection ends if it takes nothing for READ_S, and goes on if it reads slowly.

    `dropped` is called before the connection ends.
    """

    def __init__(
        self, loop: asyncio.AbstractEventLoop, transport: Any, dropped: Callable[[], object] = lambda: None
    ) -> None:
        self._loop, self._transport, self._dropped = loop, transport, dropped
        self._waiting = unsent(transport)
        self._timer = self._later()

    def _later(self) -> asyncio.TimerHandle:
        return self._loop.call_later(settings.LIMITS["READ_S"], self._look)

    def _look(self) -> None:
        before, self._waiting = self._waiting, unsent(self._transport)
        if self._waiting >= before:
            self._dropped()
            self._transport.abort()
        else:
            self._timer = self._later()

    def cancel(self) -> None:
        """Stop looking: the peer has taken enough, or is gone."""
        self._timer.cancel()
