"""The simulator's own record of its actions, by which tests and benchmarks judge.

One JSON object per line in `journal.jsonl`, with the monotonic clock that all processes of the machine share. It is
real time, however fast the simulator runs.
"""

import json
import threading
from collections import Counter
from pathlib import Path
from typing import Any

from robots.clock import TIMER, Timer


class Journal:
    """Counts events and appends them to a file; `real` is the clock that all processes of the machine share."""

    LIMIT = 8_000_000  # bytes; then the file is rotated once

    def __init__(self, path: Path, real: Timer = TIMER) -> None:
        self._path, self._real = path, real
        self._lock = threading.Lock()
        self._file = path.open("a", buffering=1)
        self.counts: Counter[str] = Counter()

    def note(self, event: str, **details: Any) -> None:
        """Write `event` with its details."""
        record = {"t": round(self._real.monotonic(), 4), "event": event, **details}
        with self._lock:
            self._file.write(json.dumps(record) + "\n")
            self.counts[event] += 1  # now that whoever waits for it finds it in the file
            if self._file.tell() > self.LIMIT:
                self._file.close()
                self._path.replace(self._path.with_suffix(".old"))
                self._file = self._path.open("a", buffering=1)
