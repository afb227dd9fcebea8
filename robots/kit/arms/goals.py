"""What a visitor can win with the objects of an arm: the tables `[[goal]]` of a description. Pure.

A goal is to build a figure of objects, to lift an object, or to catch one that swings. `judging.py` says which are won.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from math import radians, tau
from typing import Any

from scipy.spatial.transform import Rotation

from robots.kit.arms.arrangement import Arrangement, NotPossible
from robots.kit.arms.chain import Matrix
from robots.kit.arms.objects import NAME, TABLE, DescribedObject, ObjectTable, objects_of, pose_of, upright, yaw_of
from robots.kit.arms.plates import PLATE, are_studs
from robots.kit.arms.pose import apart
from robots.kit.arms.tables import BadDescription, number, numbers
from robots.kit.description import load

MOST, LONGEST_TITLE = 16, 80
BUILD, LIFT, CATCH = "build", "lift", "catch"
WITHIN_M, WITHIN_DEG = 0.003, 5.0


@dataclass(frozen=True, eq=False)
class Goal:
    """Something to win. `parts`: where each object of a figure belongs (4 x 4), in the order in which it is built.

    One is there within a length (m) and an angle (rad). `far`: how far (m) the one object of `LIFT` is lifted, and how
    far that of `CATCH` has to swing.
    """

    name: str
    title: str
    kind: str
    parts: Mapping[str, Matrix]
    within: tuple[float, float] = (WITHIN_M, radians(WITHIN_DEG))
    far: float = 0.0


def missing(described: DescribedObject, pose: Matrix, goal: Matrix) -> tuple[float, float]:
    """Return how far (m, rad) an object is from where it belongs; turns after which it looks the same are none."""
    turn = Rotation.from_matrix(goal[:3, :3].T @ pose[:3, :3])
    angle = min(
        float((Rotation.from_euler("z", -n * tau / described.turns) * turn).magnitude()) for n in range(described.turns)
    )
    return apart(pose, goal), angle


@cache
def goals_of(driver: str) -> tuple[Goal, ...]:
    """Return the goals of a robot, from its `robot.toml`. Raises BadDescription."""
    return goals_in(load(driver), objects_of(driver))


def goal_facts(driver: str) -> dict[str, Any]:
    """Return what a browser needs to show the goals: poses 4 x 4 row by row, lengths in m, angles in rad.

    Raises:
        BadDescription: a table of the goals is not valid.

    """
    goals = [
        {
            "name": goal.name, "title": goal.title, "kind": goal.kind,
            "parts": [{"object": name, "pose": pose.ravel().tolist()} for name, pose in goal.parts.items()],
        }
        for goal in goals_of(driver)
    ]  # fmt: skip
    return {"goals": goals} if goals else {}


def goals_in(description: Mapping[str, Any], table: ObjectTable) -> tuple[Goal, ...]:
    """Return the goals of a description. Raises BadDescription."""
    listed = description.get("goal", ())
    if not isinstance(listed, Sequence) or isinstance(listed, str) or len(listed) > MOST:
        raise BadDescription(f"at most {MOST} tables [[goal]] are possible")
    goals = tuple(_goal(count, one, table) for count, one in enumerate(listed, 1))
    if len({goal.name for goal in goals}) != len(goals):
        raise BadDescription("two goals have the same name")
    return goals


def _goal(count: int, one: Any, table: ObjectTable) -> Goal:
    name = one.get("name") if isinstance(one, Mapping) else None
    if not isinstance(name, str) or not NAME.fullmatch(name):
        raise BadDescription(f"goal {count} needs a name of letters, digits and hyphens")
    who, title, kind = f"goal {name}", one.get("title"), one.get("kind")
    if not isinstance(title, str) or not 0 < len(title) <= LONGEST_TITLE:
        raise BadDescription(f"{who}: title is what people read, at most {LONGEST_TITLE} characters")
    if kind == BUILD:
        return Goal(name, title, kind, _figure(who, one, table), _within(who, one))
    if kind not in (LIFT, CATCH):
        raise BadDescription(f"{who}: kind is {BUILD}, {LIFT} or {CATCH}")
    described, far = table.named(str(one.get("object"))), number(who, one, "far_m")
    if described is None:
        raise BadDescription(f"{who}: object names none of {', '.join(table.objects)}")
    if not 0.0 < far <= 1.0:
        raise BadDescription(f"{who}: far_m is above 0 and at most 1")
    pose = pose_of(described.first)
    pose[2, 3] += far if kind == LIFT else 0.0
    return Goal(name, title, kind, {described.name: pose}, far=far)


def _within(who: str, one: Mapping[str, Any]) -> tuple[float, float]:
    metres, degrees = number(who, one, "within_m", WITHIN_M), number(who, one, "within_deg", WITHIN_DEG)
    if not (0.0 < metres <= 0.1 and 0.0 < degrees <= 180.0):
        raise BadDescription(f"{who}: within_m is above 0 and at most 0.1, within_deg above 0 and at most 180")
    return metres, radians(degrees)


def _figure(who: str, one: Mapping[str, Any], table: ObjectTable) -> dict[str, Matrix]:
    """Return where the parts of a figure belong; each is checked as a task that puts it there would be."""
    parts = one.get("part", ())
    if not isinstance(parts, Sequence) or isinstance(parts, str) or not parts:
        raise BadDescription(f"{who}: a figure needs at least one [[goal.part]]")
    built = Arrangement(table)
    for part in parts:
        name = part.get("object") if isinstance(part, Mapping) else None
        described = table.named(str(name))
        if described is None:
            raise BadDescription(f"{who}: a part's object names none of {', '.join(table.objects)}")
        if described.name in built.places:
            raise BadDescription(f"{who}: {described.name} is a part twice")
        try:
            pose = _part(f"{who}, part {name}", part, described, built)
            built.check_place(described.name, pose)
        except NotPossible as error:
            raise BadDescription(f"{who}, part {name}: {error}") from error
        built = built.with_place(described.name, pose)
    return {name: pose_of(placed) for name, placed in built.places.items()}


def _part(who: str, part: Mapping[str, Any], described: DescribedObject, built: Arrangement) -> Matrix:
    """Return where a part belongs. Raises BadDescription, NotPossible."""
    on, turned, first = part.get("on"), radians(number(who, part, "turned_deg", 0.0)), pose_of(described.first)
    if on not in (TABLE, PLATE, *built.places):
        raise BadDescription(f"{who}: on is {TABLE}, {PLATE}, or the object of a part before it")
    if on == TABLE:
        x, y = numbers(who, part, "at_m", 2)
        return described.standing(upright(first, turned), x, y, built.table.height)
    stud = part.get("stud")
    if stud is not None and (on != PLATE or not are_studs(stud)):
        raise BadDescription(f"{who}: stud is a column and a row of the {PLATE}, two whole numbers from 1")
    dx, dy = numbers(who, part, "by_m", 2) if "by_m" in part else (0.0, 0.0)
    base, _ = built.bearing(on)
    rotation = upright(first, yaw_of(base) + turned)
    return built.on_top(described.name, rotation, on, (dx, dy), None if stud is None else (stud[0], stud[1]))
