"""HTTP answers of network cameras, read within one time limit for the whole answer."""

import http.client
import io
import socket
import time
from typing import Any


class _LimitedReader(io.RawIOBase):
    """Raw input from a socket with a limit for the whole answer and one for each silence."""

    def __init__(self, raw: Any, line: socket.socket, until: float, silence: float) -> None:
        self._raw, self._line, self._until, self._silence = raw, line, until, silence

    def readable(self) -> bool:
        """Return True."""
        return True

    def readinto(self, buffer: Any) -> int | None:
        """Read available bytes. Raises TimeoutError after the limit."""
        left = self._until - time.monotonic()
        if left <= 0:
            raise TimeoutError("The answer took too long.")
        self._line.settimeout(min(left, self._silence))
        got: int | None = self._raw.readinto(buffer)
        self._line.settimeout(self._silence)  # for the next request on this connection
        return got

    def close(self) -> None:
        """Close the socket's reader."""
        self._raw.close()
        super().close()


def answer_within(seconds: float, silence: float) -> type[http.client.HTTPResponse]:
    """Return a response class that must read status, head and body within `seconds` (s) of its creation.

    `silence` (s) is the longest time without a byte.
    """

    class Answer(http.client.HTTPResponse):
        def __init__(self, sock: socket.socket, *args: Any, **kwargs: Any) -> None:
            super().__init__(sock, *args, **kwargs)
            self.fp.close()
            raw = sock.makefile("rb", buffering=0)
            self.fp = io.BufferedReader(_LimitedReader(raw, sock, time.monotonic() + seconds, silence))

    return Answer
