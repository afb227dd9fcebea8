"""The museum arm's lines, for driver and simulator alike: plain text that people can type.

A line ends in LF (a CR before it is ignored), is ASCII and at most 200 characters long: one
letter, then numbers. `j k w W p g` are the paper's (Dziemian et al. 2004, "The server");
it gives letters and meaning, not units, replies or line ends. All else is ours.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum

from robots.kit.drivers.pa10.forms import FORMS, LARGEST_EPOCH, Value
from robots.kit.plain import NUMERAL

LONGEST = 200
LONGEST_ANSWER = 2000  # characters; a state has about 300
JOINTS = 6
SAID_MOST = {"q": 7200.0, "v": 72_000.0, "t": 1e6}  # in a state: degrees, degrees/s, N m
OPENING_MOST, DIGITS = 1000.0, 16  # mm; of a count
MOTIONS = "jkKl"
VELOCITIES = "JC"
BLANKS = " \t\r"  # around what a line of a program says
LONGEST_PROGRAM = 500  # lines, and steps
LONGEST_PROGRAM_S = 300.0
LONGEST_TEXT = 20_000  # characters of a program
DEEPEST = 8  # repetitions in each other
WORDED = "ib"  # a word follows the values: the optional token, the name of a box


class Mode(StrEnum):
    """The state machine register of the paper; spaces are written as underscores on the wire."""

    NO_CTRL = "NO_CTRL"
    JOINT_CTRL = "JOINT_CTRL"
    KIN_RPY_CTRL = "KIN_RPY_CTRL"
    KIN_EULER_CTRL = "KIN_EULER_CTRL"
    RANGE_ERROR = "RANGE_ERROR"
    PROG_EXEC = "PROG_EXEC"


class End(StrEnum):
    """The end of the newest motion."""

    NONE = "none"
    DONE = "done"
    REPLACED = "replaced"
    HELD = "held"
    RANGE = "range"


class Malformed(ValueError):
    """The line is not valid; the message says what was wrong and what to write."""

    code = "form"


class OutOfBounds(Malformed):
    """A number outside the bounds of the wire; the message names value, range and unit."""

    code = "range"


@dataclass(frozen=True)
class Request:
    """One line: its letter, its numbers as written, and a word if the form has one."""

    letter: str
    numbers: tuple[float, ...] = ()
    word: str = ""

    def encode(self) -> bytes:
        """Return the line's bytes."""
        parts = [self.letter, *(_written(number) for number in self.numbers)]
        return (" ".join([*parts, self.word]).strip() + "\n").encode("ascii")


def _written(number: float) -> str:
    return f"{number:.0f}" if abs(number) <= LARGEST_EPOCH and number == int(number) else f"{number:.10g}"


def parse(line: str, stored: bool = False) -> Request:
    """Return the request in a line; `stored`: in a line of a program.

    Raises:
        Malformed: unknown letter, wrong count, no number, not finite, too long, not plain ASCII.
        OutOfBounds: a number outside its bounds.

    """
    line = line.rstrip("\r\n")
    if len(line) > LONGEST:
        raise Malformed(f"the line is longer than {LONGEST} characters")
    if not (line.isascii() and line.replace("\t", " ").isprintable()):
        raise Malformed("the line must be plain ASCII text")
    letter, *parts = line.split() or [""]
    form = FORMS.get(letter)
    if form is None:
        raise Malformed(f"there is no command {letter[:12]!r}; known: {' '.join(FORMS)}")
    if stored and not form.stored:
        raise Malformed(f"{letter} cannot stand in a program")
    if not stored and not form.alone:
        raise Malformed(f"{letter} stands in a program only ({form.says})")
    word = parts.pop() if letter in WORDED and len(parts) == len(form.values) + 1 else ""
    if not form.least <= len(parts) <= len(form.values):
        most = len(form.values)
        wanted = f"{form.least}" if form.least == most else f"{form.least} or {most}"
        raise Malformed(f"{letter} needs {wanted} values ({form.says}), not {len(parts)}")
    if letter == "b" and (len(parts), bool(word)) not in ((0, False), (6, True)):
        raise Malformed("b needs two corners (six values) and a name, or nothing")
    return Request(letter, tuple(_number(letter, *pair) for pair in zip(form.values, parts, strict=False)), word)


def _number(letter: str, value: Value, text: str) -> float:
    try:
        found = float(text)
    except ValueError:
        found = math.nan
    if math.isnan(found) or (math.isfinite(found) and not NUMERAL.fullmatch(text)):
        raise Malformed(f"{letter}: {text[:20]!r} is not a number")
    if not value.low <= found <= value.high or (value.whole and found != int(found)):
        unit = f" {value.unit}" if value.unit else ""
        given, low, high = f"{text[:20]}{unit}", f"{value.low:g}", f"{_shown(value.high)}{unit}"
        if value.whole:
            raise OutOfBounds(f"{letter}: {value.name} is {given}; it must be a whole number from {low} to {high}")
        raise OutOfBounds(f"{letter}: {value.name} is {given}; it must be from {low} to {high}")
    return found + 0.0


def _shown(bound: float) -> str:
    return f"{bound:.0f}" if bound == int(bound) else f"{bound:g}"


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
        try:
            letter, mode, *parts = line.split()
            if letter != "s":
                raise ValueError(letter)
            said = dict(part.split("=", 1) for part in parts)
            six = {key: tuple(_within(v, most) for v in said[key].split(",")) for key, most in SAID_MOST.items()}
            if any(len(values) != JOINTS for values in six.values()):
                raise ValueError("six values are needed")
            counts = {key: _count(said[key]) for key in ("motion", "boot", "program", "step", "gripper")}
            return cls(
                Mode(mode), counts["motion"], End(said["end"]), counts["boot"], counts["program"],
                counts["step"], counts["gripper"], _within(said["opening"], OPENING_MOST) / 1000, said["moving"] == "1",
                tuple(math.radians(v) for v in six["q"]), tuple(math.radians(v) for v in six["v"]), six["t"],
                "" if said["note"] == "-" else said["note"].replace("_", " "),
            )  # fmt: skip
        except (KeyError, ValueError) as error:
            raise Malformed(f"this is not a state: {line[:60]!r}") from error


def _within(text: str, most: float) -> float:
    """Return a number of a controller's answer. Raises ValueError where it is none, not finite, or too large."""
    if not NUMERAL.fullmatch(text) or not -most <= float(text) <= most:
        raise ValueError(f"{text[:20]} cannot be meant")
    return float(text)


def _count(text: str) -> int:
    """Return a count of a controller's answer. Raises ValueError where it is none, or has more digits than is sane."""
    if not (text.isascii() and text.isdecimal() and len(text) <= DIGITS):
        raise ValueError(f"{text[:20]} is no count")
    return int(text)


def _list(values: tuple[float, ...], convert: Callable[[float], float], digits: int) -> str:
    return ",".join(f"{convert(v):.{digits}f}" for v in values)


def lines(text: str) -> Iterator[tuple[int, str]]:
    """Yield the lines of a program that are not empty, with their numbers and without comments.

    A line ends at a line feed alone, as on the page (console/program_text.ts).
    """
    for number, line in enumerate(text.split("\n"), 1):
        if said := line.split("#")[0].strip(BLANKS):
            yield number, said


def program(text: str) -> list[Request]:
    """Return a program's steps with repetitions expanded, at most 500, of at most 500 lines that are not empty.

    Raises:
        Malformed: names the line.
    """
    if len(text) > LONGEST_TEXT:
        raise Malformed(f"the program is longer than {LONGEST_TEXT} characters")
    stack: list[tuple[int, list[Request]]] = [(1, [])]
    for count, (number, line) in enumerate(lines(text), 1):
        try:
            if count > LONGEST_PROGRAM:
                raise Malformed(f"the program is longer than {LONGEST_PROGRAM} lines")
            _nest(stack, parse(line, stored=True))
        except Malformed as error:
            raise type(error)(f"line {number}: {error}") from None
        if sum(len(steps) for _, steps in stack) > LONGEST_PROGRAM:
            raise Malformed(f"line {number}: the program is longer than {LONGEST_PROGRAM} steps")
    if len(stack) > 1:
        raise Malformed("a repetition (R) has no end (E)")
    return stack[0][1]


def _nest(stack: list[tuple[int, list[Request]]], request: Request) -> None:
    if request.letter == "R":
        if len(stack) > DEEPEST:
            raise Malformed(f"repetitions stand at most {DEEPEST} deep in each other")
        stack.append((int(request.numbers[0]), []))
    elif request.letter == "E":
        if len(stack) == 1:
            raise Malformed("E ends a repetition (R); there is none")
        times, steps = stack.pop()
        if times * len(steps) > LONGEST_PROGRAM:
            raise Malformed(f"the repetition is longer than {LONGEST_PROGRAM} steps")
        stack[-1][1].extend(steps * times)
    else:
        stack[-1][1].append(request)
