"""The simulator's own record of its actions, from which tests and benchmarks judge it.

One JSON object per line in `journal.jsonl`, with the monotonic clock that all processes of the machine share. It is
real time, however fast the simulator runs. Events that a client can cause at will are all counted, but a token bucket
for each kind, of 100 lines and 5 more a second, limits what is written; the next line says how many were `left_out`.
"""

import json
import threading
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from robots.kit.clock import TIMER, Timer

Note = Callable[..., None]  # `Journal.note`, or a test's
BY_CLIENTS = frozenset({"connected", "disconnected", "refused", "late", "hold", "crash", "bad_checksum", "claim"})
BURST, A_SECOND = 100.0, 5.0  # of the token bucket for each of these, in lines


class Journal:
    """Counts events and appends them to a file; `real` is the clock that all processes of the machine share."""

    LIMIT = 8_000_000  # bytes; then the file is rotated once

    def __init__(self, path: Path, real: Timer = TIMER) -> None:
        self._path, self._real = path, real
        self._lock = threading.Lock()
        self.listener: Callable[[dict[str, Any]], None] | None = None  # gets each event, in the thread that records it
        self._file = path.open("a", buffering=1)
        self.counts: Counter[str] = Counter()
        self._left_out: Counter[str] = Counter()
        self._room = {event: (BURST, 0.0) for event in BY_CLIENTS}  # tokens, and when they were counted

    def note(self, event: str, **details: Any) -> None:
        """Count `event`, and write it with its details if its token bucket has room."""
        now = self._real.monotonic()
        record = {"t": round(now, 4), "event": event, **details}
        if self.listener is not None:
            self.listener(record)
        with self._lock:
            if not self._has_room(event, now):
                self._left_out[event] += 1
                self.counts[event] += 1
                return
            if left_out := self._left_out.pop(event, 0):
                record["left_out"] = left_out
            self._file.write(json.dumps(record) + "\n")
            self.counts[event] += 1  # after the write, because a reader that sees the count looks into the file
            if self._file.tell() > self.LIMIT:
                self._file.close()
                self._path.replace(self._path.with_suffix(".old"))
                self._file = self._path.open("a", buffering=1)

    def close(self) -> None:
        """Write nothing more."""
        self._file.close()

    def _has_room(self, event: str, now: float) -> bool:
        if event not in BY_CLIENTS:
            return True
        room, since = self._room[event]
        room = min(BURST, room + (now - since) * A_SECOND)
        self._room[event] = (room - 1 if room >= 1 else room), now
        return room >= 1
