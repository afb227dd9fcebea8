"""A network camera's answer, read within one limit for the whole of it: one that dribbles is no camera."""

import http.client
import io
import socket
import time
from typing import Any


class _Patient(io.RawIOBase):
    """What comes from a socket until the limit is over, with no longer silence than it is given."""

    def __init__(self, raw: Any, line: socket.socket, until: float, silence: float) -> None:
        self._raw, self._line, self._until, self._silence = raw, line, until, silence

    def readable(self) -> bool:
        """It is."""
        return True

    def readinto(self, buffer: Any) -> int | None:
        """Read what has come. Raises TimeoutError after the limit."""
        left = self._until - time.monotonic()
        if left <= 0:
            raise TimeoutError("The answer took too long.")
        self._line.settimeout(min(left, self._silence))
        got: int | None = self._raw.readinto(buffer)
        self._line.settimeout(self._silence)  # for what is sent next on this line
        return got

    def close(self) -> None:
        """Close what is read from."""
        self._raw.close()
        super().close()


def answer_within(seconds: float, silence: float) -> type[http.client.HTTPResponse]:
    """Return a response class that reads status, head and body within `seconds` (s) from its making.

    `silence` (s) is the longest time without a byte.
    """

    class Answer(http.client.HTTPResponse):
        def __init__(self, sock: socket.socket, *args: Any, **kwargs: Any) -> None:
            super().__init__(sock, *args, **kwargs)
            self.fp.close()
            raw = sock.makefile("rb", buffering=0)
            self.fp = io.BufferedReader(_Patient(raw, sock, time.monotonic() + seconds, silence))

    return Answer
