"""The museum arm's lines, used by driver and simulator alike: plain text, typeable by hand.

A line ends in LF (CR before it is forgiven), is ASCII and at most 200 characters long; one
letter, then numbers. `j k w W p g` are the paper's (Dziemian et al. 2004, "The server");
it gives letters and meaning, not units, replies or line ends. All else is ours.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

LONGEST = 200
JOINTS = 6


class Mode(StrEnum):
    """The state machine register of the paper; spaces are written as underscores on the wire."""

    NO_CTRL = "NO_CTRL"
    JOINT_CTRL = "JOINT_CTRL"
    KIN_RPY_CTRL = "KIN_RPY_CTRL"
    KIN_EULER_CTRL = "KIN_EULER_CTRL"
    RANGE_ERROR = "RANGE_ERROR"
    PROG_EXEC = "PROG_EXEC"


class End(StrEnum):
    """How the newest motion ended."""

    NONE = "none"
    DONE = "done"
    REPLACED = "replaced"
    HELD = "held"
    RANGE = "range"


@dataclass(frozen=True)
class Form:
    """What follows a letter: how many numbers, how many more at will, and what it does."""

    letter: str
    least: int
    most: int
    says: str
    papers: bool = False


FORMS = {
    form.letter: form
    for form in (
        Form("j", 6, 7, "six joint positions in degrees; then a share of full speed, 0.05 to 1, at will", True),
        Form("k", 6, 7, "x y z in mm, roll pitch yaw in degrees; speed at will", True),
        Form("K", 6, 7, "x y z in mm, Euler Z-Y-Z in degrees; speed at will"),
        Form("l", 6, 7, "as k, on a straight line of the hand"),
        Form("w", 0, 0, "asks: a awaiting commands, b busy, e error", True),
        Form("W", 0, 0, "answers as w when the arm rests", True),
        Form("p", 1, 1, "execute the program of that number", True),
        Form("g", 1, 1, "gripper: 0 opens, 1 closes", True),
        Form("s", 0, 0, "the whole state in one line"),
        Form("h", 0, 0, "hold: come to rest now; taken at any moment"),
        Form("J", 6, 6, "six joint velocities in degrees/s; given again within 0.25 s or the arm rests"),
        Form("C", 6, 6, "velocity of the hand: mm/s and degrees/s about x y z; given again as J"),
        Form("d", 1, 1, "in a program: wait so many seconds"),
        Form("R", 1, 1, "in a program: repeat what follows, up to E, so many times"),
        Form("E", 0, 0, "in a program: the end of a repetition"),
        Form("u", 1, 1, "take over a program of that number: its lines follow, a line with a dot ends it"),
        Form("b", 0, 7, "a keeper's forbidden box: two corners in mm, a name; alone: takes all of them away"),
        Form("i", 1, 2, "who asks: epoch of the owner, token where the robot wants one"),
    )
}
PROGRAM = "jkKlgdREW"
MOTIONS = "jkKl"
WORDED = "ib"  # the last of all their values is a word


class Malformed(ValueError):
    """The line makes no sense; the message says what was wrong and what to write."""


@dataclass(frozen=True)
class Request:
    """One line: its letter, its numbers as written, a word where the form has one."""

    letter: str
    numbers: tuple[float, ...] = ()
    word: str = ""

    def encode(self) -> bytes:
        """Return the line's bytes."""
        parts = [self.letter, *(f"{number:.10g}" for number in self.numbers)]
        return (" ".join([*parts, self.word]).strip() + "\n").encode("ascii")


def parse(line: str) -> Request:
    """Return the request in a line.

    Raises:
        Malformed: unknown letter, wrong count, no number, not finite, too long.

    """
    if len(line) > LONGEST:
        raise Malformed(f"the line is longer than {LONGEST} characters")
    letter, *parts = line.split() or [""]
    form = FORMS.get(letter)
    if form is None:
        raise Malformed(f"there is no command {letter[:12]!r}; known: {' '.join(FORMS)}")
    if not form.least <= len(parts) <= form.most:
        wanted = f"{form.least}" if form.least == form.most else f"{form.least} or {form.most}"
        raise Malformed(f"{letter} wants {wanted} values ({form.says}), not {len(parts)}")
    word = parts.pop() if letter in WORDED and len(parts) == form.most else ""
    if letter == "b" and len(parts) not in (0, 6):
        raise Malformed("b wants two corners, six values, and a name; or nothing at all")
    return Request(letter, tuple(_number(letter, part) for part in parts), word)


def _number(letter: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise Malformed(f"{letter}: {text[:20]!r} is no number") from None
    if not math.isfinite(value):
        raise Malformed(f"{letter}: {text[:20]!r} is no finite number")
    return value


@dataclass(frozen=True)
class ArmState:
    """The answer to `s`, in SI units: joints rad, rad/s, N m; gripper 0 open, 1 closed, opening in m."""

    mode: Mode
    motion: int
    end: End
    boot: int
    program: int
    step: int
    gripper: int
    opening: float
    moving: bool
    q: tuple[float, ...]
    v: tuple[float, ...]
    torque: tuple[float, ...]
    note: str = ""

    def encode(self) -> str:
        """Return the line, without its end."""
        return " ".join(
            [
                "s", self.mode, f"motion={self.motion}", f"end={self.end}", f"boot={self.boot}",
                f"program={self.program}", f"step={self.step}", f"gripper={self.gripper}",
                f"opening={self.opening * 1000:.2f}", f"moving={int(self.moving)}",
                f"q={_list(self.q, math.degrees, 5)}", f"v={_list(self.v, math.degrees, 3)}",
                f"t={_list(self.torque, float, 2)}", f"note={self.note.replace(' ', '_') or '-'}",
            ]
        )  # fmt: skip

    @classmethod
    def decode(cls, line: str) -> "ArmState":
        """Return the state in a line. Raises Malformed."""
        letter, mode, *parts = line.split()
        try:
            if letter != "s":
                raise ValueError(letter)
            said = dict(part.split("=", 1) for part in parts)
            six = {key: tuple(float(v) for v in said[key].split(",")) for key in "qvt"}
            if any(len(values) != JOINTS for values in six.values()):
                raise ValueError("six values are wanted")
            return cls(
                Mode(mode), int(said["motion"]), End(said["end"]), int(said["boot"]), int(said["program"]),
                int(said["step"]), int(said["gripper"]), float(said["opening"]) / 1000, said["moving"] == "1",
                tuple(math.radians(v) for v in six["q"]), tuple(math.radians(v) for v in six["v"]), six["t"],
                "" if said["note"] == "-" else said["note"].replace("_", " "),
            )  # fmt: skip
        except (KeyError, ValueError) as error:
            raise Malformed(f"this is no state: {line[:60]!r}") from error


def _list(values: tuple[float, ...], convert: Callable[[float], float], digits: int) -> str:
    return ",".join(f"{convert(v):.{digits}f}" for v in values)


def program(text: str) -> list[Request]:
    """Return a program's steps with repetitions written out, at most 500.

    Raises:
        Malformed: names the line.

    """
    stack: list[tuple[int, list[Request]]] = [(1, [])]
    for number, line in enumerate(text.splitlines(), 1):
        if not line.split("#")[0].strip():
            continue
        try:
            request = parse(line.split("#")[0])
            if request.letter not in PROGRAM:
                raise Malformed(f"{request.letter} cannot stand in a program")
            _nest(stack, request)
        except Malformed as error:
            raise Malformed(f"line {number}: {error}") from None
        if sum(len(steps) for _, steps in stack) > LONGEST_PROGRAM:
            raise Malformed(f"line {number}: the program is longer than {LONGEST_PROGRAM} steps")
    if len(stack) > 1:
        raise Malformed("a repetition (R) has no end (E)")
    return stack[0][1]


LONGEST_PROGRAM = 500


def _nest(stack: list[tuple[int, list[Request]]], request: Request) -> None:
    if request.letter == "R":
        times = request.numbers[0]
        if times != int(times) or not 1 <= times <= 100:
            raise Malformed("a repetition is made 1 to 100 times")
        stack.append((int(times), []))
    elif request.letter == "E":
        if len(stack) == 1:
            raise Malformed("E ends a repetition (R); there is none")
        times, steps = stack.pop()
        if times * len(steps) > LONGEST_PROGRAM:
            raise Malformed(f"the repetition is longer than {LONGEST_PROGRAM} steps")
        stack[-1][1].extend(steps * times)
    else:
        stack[-1][1].append(request)
