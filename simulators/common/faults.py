"""Faults on request: a simulator has one fault board, which a Unix socket serves while it runs.

A line is a JSON object: ``{"verb": "corrupt", "value": 0.1, "seed": 7, "count": 5}``. The answer is one JSON line.
The verb `clear` removes every fault, `status` returns counters.
"""

import json
import random
import socketserver
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from typing import Any

VERBS = frozenset(
    {
        "awol", "mute", "slow", "drop", "corrupt", "double", "double_ack", "limit_hit", "power_cycle",
        "cam_freeze", "cam_flicker", "cam_black", "cam_gone", "cam_slow", "cam_size", "cam_stamp", "drift", "disturb",
        "mic_gone", "mic_mute", "slip", "restart", "stall", "ir_dead", "carried", "charge",
        "contacts_bent", "false_marker", "cut", "flushed_hold", "half_frame", "lying_length", "far",
        "blind_infrared", "sonar_ghost", "dead_encoder", "moved_case", "beacon_gone",
        "intrude", "vanish", "nudge", "gust",
    }
)  # fmt: skip


@dataclass
class FaultBoard:
    """The present faults. Thread safe; random numbers come from one seeded source."""

    seed: int = 1
    _values: dict[str, float] = field(default_factory=dict)
    _counts: dict[str, int] = field(default_factory=dict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def __post_init__(self) -> None:
        """Create the random source."""
        self.random = random.Random(self.seed)

    def set(self, verb: str, value: float = 1.0, count: int | None = None) -> None:
        """Switch a fault on; after `count` uses it switches itself off."""
        if verb not in VERBS:
            raise ValueError(f"unknown fault {verb!r}; known: {', '.join(sorted(VERBS))}")
        if not isfinite(value):
            raise ValueError("the value must be a finite number")
        with self._lock:
            self._values[verb] = value
            if count is not None:
                self._counts[verb] = count
            else:
                self._counts.pop(verb, None)

    def clear(self) -> None:
        """Remove every fault."""
        with self._lock:
            self._values.clear()
            self._counts.clear()

    def value(self, verb: str) -> float:
        """Return the fault's value, 0 if it is off; this does not count as a use."""
        return self._values.get(verb, 0.0)

    def take(self, verb: str) -> float:
        """Return the fault's value and count one use of it."""
        if verb not in self._values:
            return 0.0  # a control loop asks hundreds of times a second
        with self._lock:
            value = self._values.get(verb, 0.0)
            if value and verb in self._counts:
                self._counts[verb] -= 1
                if self._counts[verb] <= 0:
                    self._values.pop(verb, None)
                    self._counts.pop(verb, None)
            return value

    def once(self, verb: str) -> float:
        """Return the fault's value, 0 if it is off, and switch it off."""
        with self._lock:
            self._counts.pop(verb, None)
            return self._values.pop(verb, 0.0)

    def chance(self, verb: str) -> bool:
        """Return whether a fault, whose value is a probability, happens now."""
        share = self.value(verb)
        if not share or self.random.random() >= share:
            return False
        self.take(verb)
        return True

    def spoil(self, data: bytes) -> bytes:
        """Return bytes that go over a line, some of them corrupted, dropped or doubled as the present faults say."""
        if not any(self.value(verb) for verb in ("corrupt", "drop", "double")):
            return data
        out = bytearray()
        for byte in data:
            if self.chance("drop"):
                continue
            if self.chance("corrupt"):
                byte ^= 1 << self.random.randrange(8)
            out += bytes((byte,)) * (2 if self.chance("double") else 1)
        return bytes(out)

    def present(self) -> dict[str, float]:
        """Return all present faults."""
        with self._lock:
            return dict(self._values)


def serve(path: Path, board: FaultBoard, status: Callable[[], dict[str, Any]]) -> None:
    """Answer fault requests on a Unix socket at `path`, in a thread of its own."""

    class Handler(socketserver.StreamRequestHandler):
        def handle(self) -> None:
            for line in self.rfile:
                self.wfile.write(json.dumps(_answer(line, board, status)).encode() + b"\n")

    path.unlink(missing_ok=True)
    server = socketserver.ThreadingUnixStreamServer(str(path), Handler)
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, daemon=True, name="faults").start()


def _answer(line: bytes, board: FaultBoard, status: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    try:
        asked = json.loads(line)
        verb = asked["verb"]
        if verb == "clear":
            board.clear()
        elif verb != "status":
            if "seed" in asked:
                board.random.seed(asked["seed"])
            count = asked.get("count")
            board.set(verb, float(asked.get("value", 1.0)), None if count is None else int(count))
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError) as error:
        return {"ok": False, "error": str(error)}
    return {"ok": True, "faults": board.present(), **status()}
