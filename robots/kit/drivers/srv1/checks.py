"""Checks and previews of the rover's commands, before anything moves, and the floor of its hall.

A command is refused if it leads to a place where the rover cannot stand, and a rule set is refused if the rover cannot
brake by it. A preview is the path in the rover's own frame, with the judgements of its steps.
"""

from bisect import bisect_right
from math import ceil, cos, hypot, isfinite, remainder, sin, tau

from robots.kit.contract.capabilities import Foreseen
from robots.kit.contract.errors import BadRequest
from robots.kit.contract.find import spec_of
from robots.kit.contract.floor import Floor
from robots.kit.contract.session import JSON, RobotState
from robots.kit.contract.spec import Spec
from robots.kit.contract.values import known_command, number, within
from robots.kit.drivers.srv1.hall import hall
from robots.kit.drivers.srv1.missions import Leg, Pose, Step, judge, parse, refuse
from robots.kit.drivers.srv1.rules import rules_of
from robots.kit.drivers.srv1.ways import way

BETWEEN_M, BETWEEN_RAD = 0.10, 0.20  # two poses of a path
MOST = 2000


def check(kind: str, args: JSON, settings: JSON, state: RobotState | None) -> None:
    """Raise BadRequest or OutOfWorkspace where a command cannot be carried out from where the rover is."""
    within(known_command(described(), kind, args), args)
    here = pose_of(state)
    if kind == "go":
        way((here[0], here[1]), (number(args, "x"), number(args, "y")))
    elif kind == "mission":
        refuse(judge(parse(str(args["text"])), here)[1])
    elif kind == "rules":
        rules_of(str(args["text"]))


def described() -> Spec:
    """Return the rover's spec."""
    return spec_of("srv1")


def pose_of(state: RobotState | None) -> Pose:
    """Return where the rover is (m, m, rad); at home where that is not known."""
    if state is None or len(state.pose) != 3:
        return hall().home
    return state.pose[0], state.pose[1], state.pose[2]


def foresee(kind: str, args: JSON, joints: tuple[float, ...], settings: JSON) -> Foreseen:
    """Return the path of a command from the pose `joints` (m, m, rad; from home where there is none).

    Raises BadRequest. A step that cannot be done has a judgement.
    """
    within(known_command(described(), kind, args), args)
    here = start(joints)
    steps = steps_of(kind, args)
    found, said = judge(steps, here)
    poses, times = sampled(found, here)
    return Foreseen(
        seconds=sum(leg.seconds for leg in found), poses=tuple(_own(pose, here) for pose in poses), times=tuple(times),
        steps=tuple(_step_at(found, at) for at in times), judgements=tuple(said),
    )  # fmt: skip


def steps_of(kind: str, args: JSON) -> list[Step]:
    """Return the steps that a command is. Raises BadRequest."""
    if kind == "mission":
        return parse(str(args["text"]))
    if kind == "go":
        return [Step("go", (number(args, "x"), number(args, "y")))]
    if kind == "turn":
        return [Step("turn", (number(args, "angle"),))]
    raise BadRequest(f"There is no path to show for the command {kind}: it leads to no place.")


def start(joints: tuple[float, ...]) -> Pose:
    """Return the pose at which a path begins. Raises BadRequest."""
    if not joints:
        return hall().home
    told = [number({"pose": value}, "pose") for value in joints]
    inside = len(told) == 3 and 0 <= told[0] <= hall().width and 0 <= told[1] <= hall().depth
    if not inside or not all(map(isfinite, told)):
        raise BadRequest("The present pose must be a place in the hall and a heading.")
    return told[0], told[1], remainder(told[2], tau)


def sampled(legs: list[Leg], here: Pose) -> tuple[list[Pose], list[float]]:
    """Return poses along the legs and the time of each (s): turns in place, then straight lines.

    At most MOST, the first and the last among them.
    """
    poses, times, passed = [here], [0.0], 0.0
    for leg in legs:
        weights = [_weight(a, b) for a, b in zip(leg.poses, leg.poses[1:], strict=False)]
        whole = sum(weights)
        for begin, end, weight in zip(leg.poses, leg.poses[1:], weights, strict=False):
            lasts = leg.seconds * weight / whole if whole else 0.0
            parts = list(_between(begin, end))
            for number_, pose in enumerate(parts, 1):
                poses.append(pose)
                times.append(passed + lasts * number_ / len(parts))
            passed += lasts
        if not whole:
            passed += leg.seconds
            poses.append(poses[-1])
            times.append(passed)
    last = len(poses) - 1
    shown = range(last + 1) if last < MOST else [n * last // (MOST - 1) for n in range(MOST)]
    return [poses[n] for n in shown], [times[n] for n in shown]


def _weight(begin: Pose, end: Pose) -> float:
    return hypot(end[0] - begin[0], end[1] - begin[1]) + abs(remainder(end[2] - begin[2], tau)) + 1e-9


def _between(begin: Pose, end: Pose) -> list[Pose]:
    turn, away = remainder(end[2] - begin[2], tau), hypot(end[0] - begin[0], end[1] - begin[1])
    turns, lines = ceil(abs(turn) / BETWEEN_RAD), max(1, ceil(away / BETWEEN_M))
    found = [(begin[0], begin[1], remainder(begin[2] + turn * n / turns, tau)) for n in range(1, turns + 1)]
    if away > 1e-9:
        shares = (n / lines for n in range(1, lines + 1))
        found += [(begin[0] + (end[0] - begin[0]) * s, begin[1] + (end[1] - begin[1]) * s, end[2]) for s in shares]
    return found or [end]


def _own(pose: Pose, here: Pose) -> Pose:
    """Return a pose in the frame of another: x ahead of it, y to its left."""
    dx, dy = pose[0] - here[0], pose[1] - here[1]
    c, s = cos(here[2]), sin(here[2])
    return c * dx + s * dy, c * dy - s * dx, remainder(pose[2] - here[2], tau)


def _step_at(found: list[Leg], at: float) -> int:
    """Return the number of the step that runs at a time, counted from 1; 0 at the start."""
    ends: list[float] = []
    for leg in found:
        ends.append((ends[-1] if ends else 0.0) + leg.seconds)
    return 0 if at <= 0 or not found else found[min(bisect_right(ends, at - 1e-9), len(found) - 1)].step


def floor_plan(_settings: JSON) -> Floor:
    """Return the hall as plots of the path show it: walls, showcases and exhibits."""
    place = hall()
    boxes = ((c.at[0] - c.half[0], c.at[1] - c.half[1], c.at[0] + c.half[0], c.at[1] + c.half[1]) for c in place.cases)
    rounds = ((e.at[0], e.at[1], e.radius) for e in place.exhibits)
    return Floor((0.0, 0.0, place.width, place.depth), tuple(boxes), tuple(rounds))
