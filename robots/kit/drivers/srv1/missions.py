"""Missions of the rover, a step a line: parsed, written and foreseen. Pure; m, s, degrees in the text.

go South
go 4.5 4.0
turn 90
look around
photograph
read
wait 5
patrol 30
say Here begins the tour.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import atan2, ceil, degrees, floor, hypot, nan, pi, radians, remainder, tau
from typing import Literal

from robots.kit.contract.capabilities import Judgement
from robots.kit.contract.errors import BadRequest, OutOfWorkspace
from robots.kit.description import load
from robots.kit.drivers.srv1.hall import Hall, hall
from robots.kit.drivers.srv1.ways import Place, way
from robots.kit.plain import NUMERAL

Verb = Literal["go", "turn", "look", "photograph", "read", "wait", "patrol", "say"]
_MISSION, _MOTION = load("srv1")["mission"], load("srv1")["motion"]
LONGEST, MOST_STEPS, LONGEST_LINE = int(_MISSION["longest"]), int(_MISSION["most_steps"]), 160
LIMIT_S = float(_MISSION["limit_s"])
MOST_WAIT_S, MOST_PATROL_S = 120.0, 120.0
SPEED_M_S, TURN_RAD_S = float(_MISSION["speed"]), float(_MISSION["turn"])
# No mission has these characters: other line ends, marks that turn or hide text, and those that no database stores.
# Without them Python and the page's script agree on what a blank is.
UNWRITABLE = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ufeff\ud800-\udfff]|\r(?!$)")
FASTEST_M_S, FASTEST_RAD_S = float(_MOTION["most_speed"]), float(_MOTION["turn"])
SETTLE_S, PICTURE_S, LOOK_S = (float(_MISSION[name]) for name in ("settle_s", "picture_s", "look_s"))
CLEAR_RAD = 2.0  # between two poses of a turn: less than half a turn, so that its direction is clear
ROAMED = "its way is judged from where the patrol before it began, because nobody knows where that will end."
TOO_LONG = (
    "Step {} cannot be done in time: even without a pause the mission would last longer than {:g} minutes there. "
    "Leave steps out."
)
MAY_BE_LATE = "Step {} may not be done in time: as a rule the mission lasts longer than {:g} minutes there."
Pose = tuple[float, float, float]


@dataclass(frozen=True)
class Step:
    """One line: of `go` the place (m), of `turn` the angle (rad, to the left), of `wait` and `patrol` seconds."""

    verb: Verb
    numbers: tuple[float, ...] = ()
    words: str = ""

    def __str__(self) -> str:
        """Return the line."""
        if self.verb == "look":
            return "look around"
        if self.verb == "go" and self.words:
            return f"go {self.words}"
        shown = (degrees(self.numbers[0]),) if self.verb == "turn" else self.numbers
        return " ".join([self.verb, *(f"{_rounded(n):g}" for n in shown), *([self.words] if self.words else [])])


@dataclass(frozen=True)
class Leg:
    """The motion of a step: the poses at its corners (m, rad), and its usual and its least duration (s)."""

    step: int
    poses: tuple[Pose, ...]
    seconds: float
    least_s: float


def parse(text: str) -> list[Step]:
    """Return the steps of a mission. Empty lines and lines that begin with # are left out.

    A line ends at a line feed alone. Lengths are of characters (code points); numbers count to thousandths. The page
    reads by the same grammar (console/mission_text.ts).

    Raises:
        BadRequest: a line is no step; the sentence names the line.

    """
    if len(text) > LONGEST:
        raise BadRequest(f"A mission has at most {LONGEST} characters.")
    found = []
    for number, line in enumerate(text.split("\n"), 1):
        if odd := UNWRITABLE.search(line):
            raise BadRequest(f"Line {number}: a mission cannot have the character U+{ord(odd[0]):04X}.")
        words = line.strip()
        if not words or words.startswith("#"):
            continue
        try:
            found.append(_step(words))
        except ValueError as error:
            raise BadRequest(f"Line {number}: {error}.") from None
        if len(found) > MOST_STEPS:
            raise BadRequest(f"A mission has at most {MOST_STEPS} steps.")
    if not found:
        raise BadRequest("A mission has at least one step.")
    return found


def _step(line: str) -> Step:
    if len(line) > LONGEST_LINE:
        raise ValueError(f"a step has at most {LONGEST_LINE} characters")
    verb, _, rest = line.partition(" ")
    rest = rest.strip()
    if verb == "go":
        return _go(rest)
    if verb == "say":
        if not rest:
            raise ValueError("say what? Write the words after it")
        return Step("say", (), rest)
    if verb == "turn":
        return Step("turn", (radians(_number(rest, -360.0, 360.0, "an angle", "°")),))
    if verb == "wait":
        return Step("wait", (_number(rest, 0.0, MOST_WAIT_S, "a time", "s"),))
    if verb == "patrol":
        return Step("patrol", (_number(rest, 1.0, MOST_PATROL_S, "a time", "s"),))
    if (verb, rest) == ("look", "around"):
        return Step("look")
    if verb == "photograph" and not rest:
        return Step("photograph")
    if verb == "read" and not rest:
        return Step("read")
    raise ValueError(
        f"there is no step “{line[:40]}”; steps are go, turn, look around, photograph, read, wait, patrol and say"
    )


def _go(rest: str) -> Step:
    node = next((n for n in hall().nodes if n.name.lower() == rest.lower()), None)
    if node is not None:
        return Step("go", node.at, node.name)
    parts = rest.split()
    if len(parts) != 2 or not re.search("[0-9]", rest):
        written = ", ".join(n.name for n in hall().nodes)  # as missions name them, in all languages
        raise ValueError(f"go where? Write two numbers in m, or one of {written}")
    x = _number(parts[0], 0.0, hall().width, "the distance from the left wall", "m")
    return Step("go", (x, _number(parts[1], 0.0, hall().depth, "the distance from the lower wall", "m")))


def _number(text: str, low: float, high: float, what: str, unit: str) -> float:
    value = float(text) if NUMERAL.fullmatch(text) else nan
    if not low <= value <= high:
        given = f"“{text[:20]}”" if text else "nothing"
        raise ValueError(f"{what} lies between {low:g} and {high:g} {unit}, not {given}")
    return _rounded(value)


def _rounded(value: float) -> float:
    """Return a number rounded to thousandths, halves up, so that Python and the page's script write the same."""
    return floor(1000 * value + 0.5) / 1000


def write(steps: Sequence[Step]) -> str:
    """Return the text of a mission."""
    return "\n".join(map(str, steps)) + "\n"


def legs(steps: Sequence[Step], here: Pose, floor: Hall | None = None) -> Iterator[Leg]:
    """Yield the leg of each step, from `here` (m, rad) on. The end of a patrol is not known: it counts as its begin.

    Raises:
        OutOfWorkspace: a step cannot be done; the sentence names it.

    """
    floor = hall() if floor is None else floor
    for number, step in enumerate(steps, 1):
        written = str(step)
        poses, seconds, least = [here], 0.0, 0.0
        if step.verb == "go":
            try:
                corners = way((here[0], here[1]), (step.numbers[0], step.numbers[1]), floor)
            except OutOfWorkspace as error:
                raise OutOfWorkspace(f"Step {number}, {written}: {error}") from None
            for corner in corners:
                here, usual, fastest = _driven(here, corner)
                poses.append(here)
                seconds, least = seconds + usual, least + fastest
        elif step.verb == "turn":
            seconds, least = abs(step.numbers[0]) / TURN_RAD_S + SETTLE_S, abs(step.numbers[0]) / FASTEST_RAD_S
            poses += _turned(here, step.numbers[0])
        elif step.verb in ("wait", "patrol"):
            seconds = least = step.numbers[0]
        elif step.verb == "look":
            seconds, least = LOOK_S, tau / FASTEST_RAD_S
            poses += _turned(here, tau)
        elif step.verb == "photograph":
            seconds = PICTURE_S
        here = poses[-1]
        yield Leg(number, tuple(poses), seconds, least)


def _turned(here: Pose, angle: float) -> list[Pose]:
    """Return the poses of a turn in place by so much (rad, to the left), without the first."""
    count = max(1, ceil(abs(angle) / CLEAR_RAD))
    return [(*here[:2], remainder(here[2] + angle * n / count, tau)) for n in range(1, count + 1)]


def _driven(here: Pose, to: Place) -> tuple[Pose, float, float]:
    """Return the pose at the end of a straight line, how long it takes as usual, and at least (s)."""
    away, heading = hypot(to[0] - here[0], to[1] - here[1]), here[2]
    if away > 1e-6:
        heading = atan2(to[1] - here[1], to[0] - here[0])
    turn = abs(remainder(heading - here[2], 2 * pi))
    usual = away / SPEED_M_S + turn / TURN_RAD_S + SETTLE_S
    return (to[0], to[1], heading), usual, away / FASTEST_M_S + turn / FASTEST_RAD_S


def judge(steps: Sequence[Step], here: Pose, limit_s: float = LIMIT_S) -> tuple[list[Leg], list[Judgement]]:
    """Return the legs of a mission from `here` (m, rad), as far as it can run, and all judgements of its steps.

    Page, server and rover judge by the same rules: while somebody writes, when the mission is sent, before it moves.
    """
    found: list[Leg] = []
    said: list[Judgement] = []
    usual, least, late, roams = 0.0, 0.0, False, False
    walk = legs(steps, here)
    while True:
        try:
            leg = next(walk)
        except StopIteration:
            return found, said
        except OutOfWorkspace as error:
            return found, [*said, Judgement(len(found) + 1, usual, str(error))]
        step = steps[leg.step - 1]
        written = str(step)
        if roams and step.verb == "go":
            said.append(Judgement(leg.step, usual, f"Step {leg.step}, {written}: {ROAMED}", False))
            roams = False
        roams = roams or step.verb == "patrol"
        usual, least = usual + leg.seconds, least + leg.least_s
        if least > limit_s:
            return found, [*said, Judgement(leg.step, usual, TOO_LONG.format(leg.step, limit_s / 60))]
        if usual > limit_s and not late:
            late = True
            said.append(Judgement(leg.step, usual, MAY_BE_LATE.format(leg.step, limit_s / 60), False))
        found.append(leg)


def refuse(judgements: Sequence[Judgement]) -> None:
    """Raise OutOfWorkspace with the first judgement that refuses a mission, if there is one."""
    for one in judgements:
        if one.refuses:
            raise OutOfWorkspace(one.sentence)
