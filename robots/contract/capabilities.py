"""What a robot may be able to do beside its commands; each is declared in its spec or is not offered.

Functions are named by import path (`package.module:name`), so that reading a spec loads nothing heavy.
They are pure: no wire, no Django. They are called with what people sent, so each takes at most 0.2 s of a
processor and 50 MB whatever the values are, and raises nothing but errors of `robots.drivers.errors`.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """A robot's own check of a command, in place of the check of names, types and ranges.

    `function(kind, args, settings, state)` returns None or raises BadRequest or OutOfWorkspace. `settings`
    are those of the robot's row, `state` is its newest `RobotState`, or None where that is not known.
    """

    function: str


@dataclass(frozen=True)
class Preview:
    """Where a command would lead, shown before it is given.

    `function(kind, args, joints, settings)` returns a `Foreseen` for the joints (rad, m) to begin with.
    `prepare(settings)` makes what takes long and is kept; it is called before, outside the bounds of time and memory.
    """

    function: str
    prepare: str = ""


@dataclass(frozen=True)
class Foreseen:
    """The answer of a preview.

    `joints` at the end and `ways` on the way there (rad, m), `hand` the positions of the tool
    ((x, y, z) in m), `seconds` on the way, `steps` which of a program's steps each of `ways` belongs to.
    """

    joints: tuple[float, ...]
    ways: tuple[tuple[float, ...], ...]
    hand: tuple[tuple[float, ...], ...]
    seconds: float
    steps: tuple[int, ...] = ()


@dataclass(frozen=True)
class Idle:
    """The command that the robot repeats while nobody asks for anything, in slices of `slice_s` seconds."""

    kind: str
    slice_s: float = 60.0


@dataclass(frozen=True)
class Need:
    """A command that comes before everybody once the scalar `channel` falls below `below`, until it reaches `until`."""

    kind: str
    channel: str
    below: float
    until: float
