"""What a robot says of itself: pure data, readable without its driver, a wire or Django."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

from robots.contract.channels import Scalar

Lane = Literal["motion", "config"]
TURN, ANYONE, STAFF = "turn", "anyone", "staff"
C = TypeVar("C")


@dataclass(frozen=True)
class Argument:
    """One value of a command: name, unit, inclusive range; of a text, the range of its length in characters."""

    name: str
    unit: str
    low: float
    high: float
    required: bool = True
    text: bool = False


@dataclass(frozen=True)
class CommandKind:
    """A command that a robot understands.

    `level` is the clearance that it needs. `asked_by` says who may ask for it: whoever has the turn
    (`turn`), everybody whose clearance suffices, as a job that waits (`anyone`), staff (`staff`).
    `limit_s` is the longest time from its beginning to its end, in seconds. One command of the lane
    `motion` runs at a time; one of the lane `config` runs beside it, and `default` holds the arguments
    that handover and a job's end restore.
    """

    kind: str
    label: str
    arguments: tuple[Argument, ...] = ()
    level: int = 1
    limit_s: float = 15.0
    lane: Lane = "motion"
    asked_by: frozenset[str] = frozenset({TURN})
    default: Mapping[str, Any] | None = None
    moves: bool = True
    still_after: bool = True  # a new stable picture belongs to its end, where there is a camera
    held: bool = False  # it goes on for as long as keep-alives arrive
    replaceable: bool = False  # a newer one may take its place in motion; its driver asks `permit` on the way
    progress: bool = False  # it tells how far it is

    def open_to(self, who: str) -> bool:
        """Tell whether `who` (`turn`, `anyone`, `staff`) may ask for it."""
        return who in self.asked_by


@dataclass(frozen=True)
class Spec:
    """What the robot can do and what it tells.

    `handover` names the commands that put it in order between two turns, `channels` the values that it
    tells beside its joints.
    """

    name: str
    commands: tuple[CommandKind, ...]
    joints: tuple[str, ...] = ()
    handover: tuple[str, ...] = ()
    channels: tuple[Scalar, ...] = ()
    capabilities: tuple[Any, ...] = ()

    def command(self, kind: str) -> CommandKind | None:
        """Return the command of that kind, or None."""
        return next((c for c in self.commands if c.kind == kind), None)

    def capability(self, kind: type[C]) -> C | None:
        """Return what the robot declares of that kind of capability (see `capabilities.py`), or None."""
        return next((c for c in self.capabilities if isinstance(c, kind)), None)

    def all_of(self, kind: type[C]) -> tuple[C, ...]:
        """Return every capability of that kind, in the order of the declaration."""
        return tuple(c for c in self.capabilities if isinstance(c, kind))
