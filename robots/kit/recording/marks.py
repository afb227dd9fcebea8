"""What commands mark on a plot: where the motion that runs goes, and the places at which the robot did its work.

No Django.
"""

from collections.abc import Mapping
from typing import Any

from robots.kit.recording.container import Message
from robots.kit.recording.paths import Place, is_place

MOST = 500  # places of work that are marked


class Marks:
    """Follows a recording's commands. `works`: the `kind` that does the work, and its `label`; None without one."""

    def __init__(self, works: Mapping[str, str] | None) -> None:
        self._kind, self.label = ((works or {}).get(name, "") for name in ("kind", "label"))
        self._goes: tuple[int, Place] | None = None  # the command that runs, and where it goes
        self._done: dict[int, Place] = {}  # by command

    @property
    def target(self) -> Place | None:
        """Return where the motion that runs goes (m); None where that is not known."""
        return self._goes[1] if self._goes else None

    @property
    def work_places(self) -> tuple[Place, ...]:
        """Return the places of its work so far (m)."""
        return tuple(self._done.values())

    def take(self, message: Message) -> None:
        """Take a stage of a command; one that cannot be read changes nothing."""
        try:
            told = message.content()
            number, state, kind = int(told["id"]), str(told["state"]), str(told["kind"])
        except (ValueError, KeyError, TypeError, OverflowError):
            return
        target = _place(told.get("target"), "place")  # told until the command has ended
        if target is not None:
            self._goes = number, target
        elif self._goes is not None and self._goes[0] == number:
            self._goes = None
        if state == "completed" and kind == self._kind and len(self._done) < MOST:
            sent = _place(told.get("result"), "sent")
            if sent is not None:
                self._done[number] = sent


def _place(told: Any, name: str) -> Place | None:
    """Return x and y of an object in an object; None where it tells no place that can be drawn."""
    held = told.get(name) if isinstance(told, Mapping) else None
    try:
        place = (float(held["x"]), float(held["y"])) if isinstance(held, Mapping) else ()
    except (KeyError, TypeError, ValueError, OverflowError):
        return None
    return place if place and is_place(place) else None
