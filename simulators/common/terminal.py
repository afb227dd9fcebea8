"""A serial line as a pseudoterminal: the simulator has one end, the other is found at a path."""

import contextlib
import os
import pty
import tty
from pathlib import Path


class Terminal:
    """The simulator's end, which never blocks; `link` becomes a symbolic link to the other. Raises OSError."""

    def __init__(self, link: Path) -> None:
        self.number, self._other = pty.openpty()
        for end in (self.number, self._other):
            tty.setraw(end)
        os.set_blocking(self.number, False)
        part = link.with_suffix(".part")
        part.unlink(missing_ok=True)
        part.symlink_to(os.ttyname(self._other))
        part.replace(link)

    def read(self, most: int) -> bytes:
        """Return at most so many bytes that have arrived. Raises OSError, also where nothing has."""
        return os.read(self.number, most)

    def write(self, data: bytes) -> None:
        """Send bytes; where nobody reads they are lost, as on a real line. Raises OSError."""
        with contextlib.suppress(BlockingIOError):
            os.write(self.number, data)
