"""The rover's motions while nobody was connected: read from its journal, and sent as a byte stream.

A packet of the stream `unseen` is JSON: `ways`, each a list of [x, y] (m) in the hall, and `events`, each
[how long ago (ms), the journal's word, x, y]. Both are empty where nothing is known.
"""

import contextlib
import json
from collections.abc import Callable, Iterable
from dataclasses import replace

from robots.kit.contract.errors import HardwareFault
from robots.kit.drivers.srv1.answers import Entries, Entry, Event, Status
from robots.kit.drivers.srv1.extension import Journal
from robots.kit.drivers.srv1.line import RoverLine

GAP_MS = 2000  # without a status for so long, something was missed
LOOKED_BACK = 64  # entries that an owner reads at its first status of this start of the rover
MOST = 256  # entries
TOLD = frozenset({
    Event.ALONE, Event.WAY, Event.HEARD, Event.REFLEX, Event.EXPIRED, Event.LEFT, Event.FAST, Event.REST, Event.ENCODER,
})  # fmt: skip
Place = tuple[float, float]


class Unseen:
    """Reads the entries of the journal that were missed; `tell` takes packets."""

    def __init__(self, line: RoverLine, tell: Callable[[bytes], object]) -> None:
        self._line, self._tell = line, tell
        self._last: Status | None = None
        self._since: int | None = None  # the first entry that was missed comes after this one; None: nothing was missed

    def take_status(self, status: Status) -> None:
        """Take each status."""
        last, self._last = self._last, status
        if last is None or last.boot != status.boot:
            self._since = max(0, status.journal - LOOKED_BACK)
        elif self._since is None and status.uptime_ms - last.uptime_ms > GAP_MS:
            self._since = last.journal

    def catch_up(self, place: Callable[[Status], Place] | None) -> None:
        """Read the entries that were missed, and send them.

        `place` returns the place in the hall (m) of a status; None where that is not known.

        If the line is lost meanwhile, they are read later.
        """
        status, since = self._last, self._since
        if status is None or since is None:
            return
        with contextlib.suppress(HardwareFault):
            found = self._read(since)
            self._since = None
            data = packet(found, status, place)
            if data is not None:
                self._tell(data)

    def _read(self, since: int) -> list[Entry]:
        found: list[Entry] = []
        while len(found) < MOST:
            answer = self._line.ask(Journal(since))
            if not isinstance(answer, Entries) or not answer.entries or answer.entries[-1].number <= since:
                break
            found += answer.entries
            since = answer.entries[-1].number
        return found


def packet(entries: Iterable[Entry], status: Status, place: Callable[[Status], Place] | None) -> bytes | None:
    """Return the packet of what the rover did without a message; None if it did nothing."""
    told = [entry for entry in entries if entry.event in TOLD]
    first = next((number for number, entry in enumerate(told) if entry.event is Event.ALONE), None)
    if first is None:
        return None
    ways: list[list[Place]] = []
    events: list[tuple[int, str, float, float]] = []
    goes = False
    for entry in told[first:]:
        x, y = place(replace(status, x=entry.x, y=entry.y)) if place else (entry.x, entry.y)
        at = round(x, 3), round(y, 3)
        events.append((max(0, status.uptime_ms - entry.uptime_ms), str(entry.event), *at))
        if entry.event is Event.ALONE:
            ways.append([at])
        elif goes:
            ways[-1].append(at)
        goes = entry.event is not Event.HEARD and (goes or entry.event is Event.ALONE)
    return json.dumps({"ways": ways if place else [], "events": events if place else []}).encode()
