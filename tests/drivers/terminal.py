"""One program at a terminal, in bytes: what the wires of the serial arms share."""

import os
import select
import time  # noqa: TID251 - the limit of a wait
import tty
from pathlib import Path


class Terminal:
    """One program on the line; `heard` is what came back. A wire's own class takes messages off what was received."""

    def __init__(self, path: Path) -> None:
        self.descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.descriptor)
        self._rest = b""
        self.heard: list[tuple] = []

    def close(self) -> None:
        os.close(self.descriptor)

    def write(self, data: bytes) -> None:
        while data:
            data = data[os.write(self.descriptor, data) :]

    def hear(self, seconds: float) -> None:
        """Listen once, at most so long."""
        if select.select([self.descriptor], [], [], seconds)[0]:
            self._rest += os.read(self.descriptor, 65536)
        self._take()

    def _take(self) -> None:
        """Take all whole messages off `_rest` into `heard`."""
        raise NotImplementedError

    def until(self, met, seconds: float = 5.0):
        """Listen until `met` of the received messages is true; return its value, or the last one at the end."""
        end = time.monotonic() + seconds
        while not (value := met(self.heard)) and time.monotonic() < end:
            self.hear(0.2)
        return value
