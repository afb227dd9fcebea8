"""The model of the objects around an arm: a belief, which says how and when each place was last known.

It outlives its owner in a file. One that cannot be read gives the first places, and says so.
"""

import logging
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from math import isfinite
from pathlib import Path

import msgspec

from robots.kit.arms.arrangement import Arrangement
from robots.kit.arms.objects import ObjectTable
from robots.kit.contract.errors import why
from robots.kit.contract.objects import Placed
from robots.kit.files import replaced

log = logging.getLogger(__name__)
LARGEST = 100_000  # bytes of the file
BROKEN = "The file with the places of the objects could not be read, so they are assumed to be where they are first."


class How(StrEnum):
    """How a place was last known."""

    START = "assumed at the start"
    ARM = "placed by the arm"
    MEASURED = "measured"
    STAFF = "set by staff"
    DROPPED = "dropped by the gripper"
    MISSED = "not found by the gripper"
    UNSEEN = "not seen where it was"


class Belief(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where an object is, None: nobody knows; how that was last known, and when (ms since 1970).

    `place` (m) and `rotation` (x, y, z, w) are in the frame of the tool while it is `held`.
    """

    how: How
    at_ms: int
    place: tuple[float, float, float] | None = None
    rotation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    held: bool = False

    @property
    def placed(self) -> Placed | None:
        """Return the place, or None."""
        return None if self.place is None else Placed(self.place, self.rotation, self.held)


@dataclass(frozen=True)
class Snapshot:
    """The beliefs of a moment, and what is to be said of them all."""

    beliefs: Mapping[str, Belief]
    note: str = ""


Tell = Callable[[Snapshot], None]


class ObjectModel:
    """The beliefs about a robot's objects; any thread. `tell` gets each change while nothing else changes."""

    def __init__(self, table: ObjectTable, file: Path | None, now_ms: Callable[[], int], tell: Tell) -> None:
        self.table, self._file, self._now_ms, self._tell = table, file, now_ms, tell
        self._lock = threading.RLock()
        self._now = self._stored()

    @property
    def arrangement(self) -> Arrangement:
        """Return where the objects are that are known."""
        places = {name: one.placed for name, one in self._now.beliefs.items()}
        return Arrangement(self.table, {name: placed for name, placed in places.items() if placed is not None})

    @property
    def held(self) -> str | None:
        """Return the name of the object in the gripper, or None."""
        return next((name for name, one in self._now.beliefs.items() if one.held), None)

    @property
    def snapshot(self) -> Snapshot:
        """Return the beliefs of now."""
        return self._now

    def belief(self, name: str) -> Belief:
        """Return what is known of an object. Raises KeyError."""
        return self._now.beliefs[name]

    def repeat(self) -> None:
        """Tell everything once more: a new listener knows nothing."""
        with self._lock:
            self._tell(self._now)

    def place(self, name: str, placed: Placed | None, how: How) -> None:
        """Take over where an object is, None: nobody knows. Raises KeyError where there is no such object."""
        self.place_all({name: placed}, how)

    def place_all(self, places: Mapping[str, Placed | None], how: How) -> None:
        """Take over where several objects are, as `place`."""
        if strange := places.keys() - self.table.objects.keys():
            raise KeyError(*strange)
        if places:
            with self._lock:
                self._change({name: self._belief(placed, how) for name, placed in places.items()})

    def take(self, after: Arrangement, how: How) -> None:
        """Take over what has changed by an act of the arm; an object that it has lost is told as dropped."""
        with self._lock:
            before, changes = self.arrangement.places, {}
            for name in self.table.objects:
                placed = after.places.get(name)
                if placed != before.get(name):
                    changes[name] = self._belief(placed, how if placed is not None else How.DROPPED)
            if changes:
                self._change(changes)

    def _belief(self, placed: Placed | None, how: How) -> Belief:
        if placed is None:
            return Belief(how, self._now_ms())
        return Belief(how, self._now_ms(), placed.place, placed.rotation, placed.held)

    def _change(self, changes: Mapping[str, Belief]) -> None:
        self._now = Snapshot({**self._now.beliefs, **changes})
        self._store()
        self._tell(self._now)

    def _stored(self) -> Snapshot:
        """Return what the file has, for the objects that there are; without a file the first places."""
        first = {name: self._belief(placed, How.START) for name, placed in self.table.first().items()}
        if self._file is None:
            return Snapshot(first)
        try:
            with self._file.open("rb") as file:
                known = msgspec.json.decode(file.read(LARGEST), type=dict[str, Belief])
        except FileNotFoundError:
            return Snapshot(first)
        except (OSError, msgspec.MsgspecError, RecursionError) as error:
            log.warning("the places of the objects are the first ones: %s", why(error))
            return Snapshot(first, BROKEN)
        if not all(self._is_sane(one) for one in known.values()) or sum(one.held for one in known.values()) > 1:
            log.warning("the places of the objects are the first ones: the file says what cannot be")
            return Snapshot(first, BROKEN)
        return Snapshot({name: known.get(name, one) for name, one in first.items()})

    def _is_sane(self, belief: Belief) -> bool:
        """Tell whether a belief of a file can be: numbers that are finite, a place in the box, a rotation."""
        if belief.place is None:
            return not belief.held
        finite = all(map(isfinite, (*belief.place, *belief.rotation)))
        inside = belief.held or all(
            low <= at <= low + size
            for at, low, size in zip(belief.place, self.table.box.low, self.table.box.size, strict=True)
        )
        return finite and inside and 0.9 < sum(part * part for part in belief.rotation) < 1.1

    def _store(self) -> None:
        if self._file is None:
            return
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            with replaced(self._file) as out:
                out.write(msgspec.json.encode(self._now.beliefs))
        except OSError as error:
            log.warning("the places of the objects are not stored: %s", why(error))
