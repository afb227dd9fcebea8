"""The steps of a task, and their text: one a line, `#` begins a comment. Pure.

Lengths in mm and angles in degrees, as people write them. `parse` and `write` are each other's inverse.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

from robots.kit.arms.objects import TABLE
from robots.kit.arms.plates import PLATE

Pair = tuple[float, float]
Three = tuple[float, float, float]


@dataclass(frozen=True)
class Grasp:
    """`grasp A`."""

    name: str


@dataclass(frozen=True)
class Feel:
    """Close the gripper at a place (x, y, in mm) of the table where nothing is known to lie; no line of a text."""

    at: Pair


@dataclass(frozen=True)
class PutOn:
    """`put A on B`, with `by DX DY` (mm) and `turned DEG` in the frame of B.

    B may be the plate; then `at COLUMN ROW` instead is the stud under A's corner of lowest column and row.
    """

    name: str
    on: str
    by: Pair | None = None
    turned: float | None = None
    stud: tuple[int, int] | None = None


@dataclass(frozen=True)
class PutAt:
    """`put A at X Y` (mm), with a yaw in degrees; without it A is turned as little as possible."""

    name: str
    at: Pair
    yaw: float | None = None


@dataclass(frozen=True)
class MoveTo:
    """`move X Y Z` (mm), with roll, pitch, yaw (degrees); without them the tool keeps its rotation."""

    place: Three
    angles: Three | None = None


@dataclass(frozen=True)
class MovePosture:
    """`move ready`: a named posture of the arm."""

    posture: str


@dataclass(frozen=True)
class Open:
    """`open`: the gripper."""


@dataclass(frozen=True)
class Close:
    """`close`: the gripper."""


@dataclass(frozen=True)
class Wait:
    """`wait 2`: so many seconds."""

    seconds: float


@dataclass(frozen=True)
class ExpectOn:
    """`expect A on B`; B may be the table or the plate."""

    name: str
    on: str


@dataclass(frozen=True)
class ExpectHeld:
    """`expect holding A`, or, without a name, `expect empty`."""

    name: str | None


Action = Grasp | Feel | PutOn | PutAt | MoveTo | MovePosture | Open | Close | Wait | ExpectOn | ExpectHeld


@dataclass(frozen=True)
class Step:
    """A step and its line, counted from 1, which two equal steps need not share; 0: it comes from no text."""

    action: Action
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Repeat:
    """`repeat N`, steps, `end`."""

    times: int
    body: "tuple[Step | Repeat, ...]"
    line: int = field(default=0, compare=False)


Body = tuple[Step | Repeat, ...]


@dataclass(frozen=True)
class Task:
    """A whole task, and how many lines its text has; 0: it comes from no text."""

    body: Body
    lines: int = field(default=0, compare=False)

    def steps(self) -> Iterator[Step]:
        """Yield the steps in the order in which they are done, repetitions expanded."""
        yield from _expanded(self.body)


def _expanded(body: Body) -> Iterator[Step]:
    for one in body:
        if isinstance(one, Step):
            yield one
        else:
            for _ in range(one.times):
                yield from _expanded(one.body)


def names(action: Action, surfaces: tuple[str, ...] = (TABLE, PLATE)) -> tuple[str, ...]:
    """Return the objects that a step is about, that which it moves first; surfaces are none."""
    match action:
        case PutOn(name, on) | ExpectOn(name, on):
            return (name,) if on in surfaces else (name, on)
        case Grasp(name) | PutAt(name):
            return (name,)
        case ExpectHeld(name) if name is not None:
            return (name,)
        case _:
            return ()


def words(action: Action) -> str:
    """Return a step's line."""
    match action:
        case Grasp(name):
            return f"grasp {name}"
        case Feel(at):
            return _felt(at)
        case PutOn(name, on, by, turned, stud):
            moved = "" if by is None else f" by {number(by[0])} {number(by[1])}"
            moved = moved if stud is None else f" at {stud[0]} {stud[1]}"
            return f"put {name} on {on}{moved}" + ("" if turned is None else f" turned {number(turned)}")
        case PutAt(name, at, yaw):
            return " ".join(("put", name, "at", *map(number, at), *(() if yaw is None else (number(yaw),))))
        case MoveTo(place, angles):
            return " ".join(("move", *map(number, (*place, *(angles or ())))))
        case MovePosture(posture):
            return f"move {posture}"
        case Open() | Close():
            return type(action).__name__.lower()
        case Wait(seconds):
            return f"wait {number(seconds)}"
        case ExpectOn(name, on):
            return f"expect {name} on {on}"
        case ExpectHeld(None):
            return "expect empty"
        case ExpectHeld(name):
            return f"expect holding {name}"


def _felt(at: Pair) -> str:
    """Return in words what is no line of a text: people read it, and it is translated."""
    return f"pick up at {number(at[0])} {number(at[1])}"


def number(value: float) -> str:
    """Return a number as a task writes it, with at most three decimals."""
    text = f"{value:.3f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def write(task: Task) -> str:
    """Return the text of a task, without its comments."""
    return "\n".join(_lines(task.body, ""))


def _lines(body: Body, indent: str) -> Iterator[str]:
    for one in body:
        if isinstance(one, Step):
            yield indent + words(one.action)
        else:
            yield f"{indent}repeat {one.times}"
            yield from _lines(one.body, indent + "  ")
            yield f"{indent}end"
