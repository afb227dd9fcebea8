"""Reads the text of a task. Its length is bounded before it is read, its steps before they are expanded. Pure."""

import re
from collections.abc import Callable
from math import inf

from robots.kit.arms.plates import MOST_STUDS, PLATE
from robots.kit.arms.tasks import steps
from robots.kit.arms.tasks.steps import Action, Body, Repeat, Step, Task
from robots.kit.plain import NUMERAL

LONGEST_TEXT = 6000  # characters
LONGEST_LINE = 120
MOST_LINES, MOST_STEPS = 200, 200  # lines; steps with repetitions expanded
MOST_TIMES, DEEPEST = 100, 4
LONGEST_WAIT_S = 30.0
FARTHEST_MM, MOST_DEG = 3000.0, 360.0
LONGEST_NAME = 30
ALLOWED = {
    "grasp": "grasp A",
    "put": "put A on B [by DX DY] [turned DEG] | put A on plate at COLUMN ROW [turned DEG] | put A at X Y [YAW]",
    "move": "move X Y Z [ROLL PITCH YAW] | move POSTURE", "open": "open", "close": "close", "wait": "wait SECONDS",
    "repeat": "repeat TIMES", "end": "end", "expect": "expect A on B | expect holding A | expect empty",
}  # fmt: skip
BLANKS, BETWEEN = " \t\r", re.compile(r"[ \t\r]+")  # no others: a page has to read the same words


class BadTask(ValueError):
    """The text is no task; the message names the line and what is allowed there."""


def parse(text: str) -> Task:
    """Return the task of a text. Raises BadTask."""
    if len(text) > LONGEST_TEXT:
        raise BadTask(f"A task has at most {LONGEST_TEXT} characters.")
    lines = text.split("\n")
    if len(lines) > MOST_LINES:
        raise BadTask(f"A task has at most {MOST_LINES} lines.")
    stack: list[tuple[int, int, list[Step | Repeat]]] = [(1, 0, [])]  # times, line, body
    for number, line in enumerate(lines, 1):
        if (said := line.split("#")[0].strip(BLANKS)) and (parts := BETWEEN.split(said)):
            try:
                if len(line) > LONGEST_LINE:
                    raise BadTask(f"a line has at most {LONGEST_LINE} characters")
                _take(stack, parts, number)
            except BadTask as error:
                raise BadTask(f"Line {number}: {error}.") from None
    if len(stack) > 1:
        raise BadTask(f"Line {stack[-1][1]}: this repeat has no end.")
    body = tuple(stack[0][2])
    if not body:
        raise BadTask("The task has no step.")
    if count(body) > MOST_STEPS:
        raise BadTask(f"The task has {count(body)} steps with its repetitions; at most {MOST_STEPS} are possible.")
    return Task(body, len(lines))


def count(body: Body) -> int:
    """Return the number of steps, repetitions expanded, without expanding them."""
    return sum(1 if isinstance(one, Step) else one.times * count(one.body) for one in body)


def _take(stack: list[tuple[int, int, list[Step | Repeat]]], parts: list[str], number: int) -> None:
    word, *rest = parts
    if word == "repeat":
        if len(stack) > DEEPEST:
            raise BadTask(f"repetitions stand at most {DEEPEST} deep in each other")
        times = _only(word, rest, 1)[0]
        if not (times.isascii() and times.isdecimal() and len(times) <= 3 and 1 <= int(times) <= MOST_TIMES):
            raise BadTask(f"repeat needs a whole number from 1 to {MOST_TIMES}, not {times[:12]!r}")
        stack.append((int(times), number, []))
    elif word == "end":
        _only(word, rest, 0)
        if len(stack) == 1:
            raise BadTask("end ends a repeat; there is none")
        times_, line, body = stack.pop()
        if not body:
            raise BadTask("nothing stands between repeat and end")
        stack[-1][2].append(Repeat(times_, tuple(body), line))
    elif word in READERS:
        stack[-1][2].append(Step(READERS[word](rest), number))
    else:
        written = ", ".join(ALLOWED)
        raise BadTask(f"{word[:12]!r} is no step; allowed: {written}")


def _only(word: str, rest: list[str], *counts: int) -> list[str]:
    if len(rest) not in counts:
        raise BadTask(f"allowed: {ALLOWED[word]}")
    return rest


def _grasp(rest: list[str]) -> Action:
    return steps.Grasp(_name(_only("grasp", rest, 1)[0]))


def _put(rest: list[str]) -> Action:
    if len(rest) in (4, 5) and rest[1] == "at":
        x, y, *yaw = (_real(part, FARTHEST_MM if n < 2 else MOST_DEG) for n, part in enumerate(rest[2:]))
        return steps.PutAt(_name(rest[0]), (x, y), yaw[0] if yaw else None)
    if len(rest) in (3, 5, 6, 8) and rest[1] == "on":
        by, turned, stud, more = None, None, None, rest[3:]
        if rest[2] == PLATE and more[:1] == ["at"] and len(more) in (3, 5):
            stud, more = (_stud(more[1]), _stud(more[2])), more[3:]
        elif more[:1] == ["by"] and len(more) in (3, 5):
            by, more = (_real(more[1], FARTHEST_MM), _real(more[2], FARTHEST_MM)), more[3:]
        if more[:1] == ["turned"] and len(more) == 2:
            turned, more = _real(more[1], MOST_DEG), []
        if not more:
            return steps.PutOn(_name(rest[0]), _name(rest[2]), by, turned, stud)
    raise BadTask(f"allowed: {ALLOWED['put']}")


def _move(rest: list[str]) -> Action:
    if len(_only("move", rest, 1, 3, 6)) == 1:
        return steps.MovePosture(_name(rest[0]))
    x, y, z = (_real(part, FARTHEST_MM) for part in rest[:3])
    if len(rest) == 3:
        return steps.MoveTo((x, y, z))
    roll, pitch, yaw = (_real(part, MOST_DEG) for part in rest[3:])
    return steps.MoveTo((x, y, z), (roll, pitch, yaw))


def _wait(rest: list[str]) -> Action:
    return steps.Wait(_real(_only("wait", rest, 1)[0], LONGEST_WAIT_S, 0.0))


def _expect(rest: list[str]) -> Action:
    if rest == ["empty"]:
        return steps.ExpectHeld(None)
    if len(rest) == 2 and rest[0] == "holding":
        return steps.ExpectHeld(_name(rest[1]))
    if len(rest) == 3 and rest[1] == "on":
        return steps.ExpectOn(_name(rest[0]), _name(rest[2]))
    raise BadTask(f"allowed: {ALLOWED['expect']}")


def _open(rest: list[str]) -> Action:
    _only("open", rest, 0)
    return steps.Open()


def _close(rest: list[str]) -> Action:
    _only("close", rest, 0)
    return steps.Close()


READERS: dict[str, Callable[[list[str]], Action]] = {
    "grasp": _grasp, "put": _put, "move": _move, "open": _open, "close": _close, "wait": _wait, "expect": _expect,
}  # fmt: skip


def _name(text: str) -> str:
    plain = text.replace("-", "").replace("_", "")
    if not (text.isascii() and plain.isalnum() and text[0].isalpha() and len(text) <= LONGEST_NAME):
        raise BadTask(f"{text[:12]!r} is no name: letters, digits and hyphens, at most {LONGEST_NAME}")
    return text


def _stud(text: str) -> int:
    """Return the number of a column or a row of studs."""
    if not (text.isascii() and text.isdecimal() and len(text) <= 2 and 1 <= int(text) <= MOST_STUDS):
        raise BadTask(f"{text[:12]!r} must be a whole number from 1 to {MOST_STUDS}, a column or row of studs")
    return int(text)


def _real(text: str, most: float, least: float = -inf) -> float:
    """Return a number, rounded to the three decimals that tasks have."""
    low = max(least, -most)
    if not NUMERAL.fullmatch(text) or not low <= float(text) <= most:
        raise BadTask(f"{text[:12]!r} must be a number from {low:g} to {most:g}")
    return round(float(text), 3) + 0.0
