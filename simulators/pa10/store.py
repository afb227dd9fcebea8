"""The programs stored in the controller. Replacing one is atomic, in memory and on disk."""

import contextlib
import json
import threading
from pathlib import Path

from robots.kit.arms.planner import Refused
from robots.kit.drivers.pa10.protocol import program
from robots.kit.files import replaced

MOST = 200
PROGRAMS = {
    1: "# greet\nj 0 -20 60 0 50 0\nR 2\nj 0 -20 60 0 90 0\nj 0 -20 60 0 30 0\nE\nj 0 25 75 0 80 0",
    2: "# red onto yellow\ng 0\nk 500 160 150 180 0 180\nl 500 160 20 180 0 180\ng 1\nl 500 160 150 180 0 180\n"
    "k 560 50 150 180 0 180\nl 560 50 61 180 0 180\ng 0\nl 560 50 150 180 0 180",
}


class ProgramStore:
    """Programs by number, stored in `path`."""

    def __init__(self, path: Path) -> None:
        self._path, self._lock = path, threading.Lock()
        self._programs = dict(PROGRAMS)
        with contextlib.suppress(OSError, ValueError, AttributeError):  # nothing stored, or unreadable
            self._programs |= {int(number): str(text) for number, text in json.loads(path.read_text()).items()}

    def numbers(self) -> list[int]:
        """Return the numbers of the stored programs."""
        return sorted(self._programs)

    def text(self, number: int) -> str | None:
        """Return a program's text, None if there is none."""
        return self._programs.get(number)

    def replace(self, number: int, text: str) -> None:
        """Replace a program. Raises Malformed, Refused; the old one stays then."""
        program(text)
        with self._lock:
            if number not in self._programs and len(self._programs) >= MOST:
                raise Refused("busy", f"there are {MOST} programs already; replace one of them")
            programs = self._programs | {number: text}
            try:
                self._write(json.dumps(programs))
            except OSError as error:
                raise Refused("busy", f"the program cannot be stored: {error.strerror}") from error
            self._programs = programs

    def _write(self, text: str) -> None:
        with replaced(self._path, sync=True) as out:
            out.write(text.encode())
