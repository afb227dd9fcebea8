"""The latch of a stop: one byte in a file, synced before the stop is confirmed.

It survives a restart of everything. The database row follows the file; the robot is latched if either says so.
"""

import os
import threading
from pathlib import Path


class StopLatch:
    """A latch in the file `path`. Thread safe."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lock = threading.Lock()
        self._set = path.exists()
        self.row_pending = self._set  # the row may not be written yet
        self.releases: int | None = None

    @property
    def latched(self) -> bool:
        """Return whether motion is forbidden."""
        return self._set

    def forbid(self, releases: int | None = None) -> None:
        """Forbid motion in memory, before the disk is written.

        `releases`: how many releases there had been by then; only a later release undoes this stop.
        """
        self._set = True
        self.releases = releases
        self.row_pending = True

    def keep(self) -> None:
        """Write the latch to disk before returning. With a full disk it is still latched in memory and in the row."""
        with self._lock:
            try:
                self._path.parent.mkdir(parents=True, exist_ok=True)
                descriptor = os.open(self._path, os.O_WRONLY | os.O_CREAT, 0o600)
                try:
                    os.write(descriptor, b"1")
                    os.fsync(descriptor)
                finally:
                    os.close(descriptor)
            except OSError:
                pass

    def release(self) -> None:
        """Allow motion again; starts none."""
        with self._lock:
            self._path.unlink(missing_ok=True)
            self._set = False
            self.row_pending = False
