"""Pick and put by a place on the table: the task that each is, with the objects as they are known. Pure.

What lies at the place decides its height: an object that is known there is grasped as its description says, or gets
what the gripper holds on its top. Where nothing is known the table does, and the gripper tells whether it holds
something.
"""

from typing import Any

from robots.kit.arms.arrangement import Arrangement
from robots.kit.arms.kinds import place_arguments
from robots.kit.arms.objects import ObjectTable, pose_of, upright
from robots.kit.arms.plates import PLATE, Plate
from robots.kit.arms.solids import is_over
from robots.kit.arms.tasks import steps
from robots.kit.arms.tasks.acts import ELSEWHERE
from robots.kit.arms.tasks.steps import Pair, Step, Task
from robots.kit.contract.errors import OutOfWorkspace
from robots.kit.contract.picking import PickAndPut
from robots.kit.contract.spec import CommandKind
from robots.kit.contract.values import number
from robots.kit.description import load

PICK, PUT = "pick", "put"
LONGEST_S = 90.0


def picking_commands(table: ObjectTable) -> tuple[CommandKind, ...]:
    """Return the two commands; their place lies in the box of the objects."""
    place = place_arguments(table.box)[:2]
    return (
        CommandKind(PICK, "Pick up here", place, limit_s=LONGEST_S),
        CommandKind(PUT, "Put down here", place, limit_s=LONGEST_S),
    )


def picking(driver: str) -> PickAndPut:
    """Return the capability of an arm, by what its gripper tells."""
    return PickAndPut(PICK, PUT, feels(driver))


def feels(driver: str) -> bool:
    """Return whether the gripper of a description tells if something is between its fingers."""
    return "joint" in load(driver)["gripper"]


def task_at(driver: str, arrangement: Arrangement, kind: str, args: dict[str, Any]) -> Task:
    """Return the task of one of the two commands. Raises OutOfWorkspace, in whole sentences."""
    x, y = number(args, "x"), number(args, "y")
    act = _pick(arrangement, (x, y), feels(driver)) if kind == PICK else _put(arrangement, (x, y))
    return Task((Step(act),))


def _pick(arrangement: Arrangement, at: Pair, can_feel: bool) -> steps.Action:
    if arrangement.held is not None:
        raise OutOfWorkspace(f"The gripper holds {arrangement.held} already. Put it down first.")
    name = highest(arrangement, at)
    if name is not None:
        return steps.Grasp(name)
    if not can_feel:
        raise OutOfWorkspace("Nothing is known to lie there. Choose an object. This gripper cannot feel.")
    _on_table(arrangement.table, at)
    return steps.Feel(_mm(at))


def _put(arrangement: Arrangement, at: Pair) -> steps.Action:
    held = arrangement.held
    if held is None:
        raise OutOfWorkspace("The gripper holds nothing. Pick something up first.")
    name = highest(arrangement, at)
    if name is not None:
        return steps.PutOn(held, name)
    plate = arrangement.table.plate
    if plate is not None and is_over(plate.solid, *at):
        return steps.PutOn(held, PLATE, stud=_stud(arrangement, plate, held, at))
    _on_table(arrangement.table, at)
    return steps.PutAt(held, _mm(at))


def highest(arrangement: Arrangement, at: Pair) -> str | None:
    """Return the highest object that lies over a place (x, y, in m); None where none is known to."""
    over = {name: solid.top for name, solid in arrangement.lying() if name != PLATE and is_over(solid, *at)}
    return max(over, key=over.__getitem__, default=None)


def _stud(arrangement: Arrangement, plate: Plate, name: str, at: Pair) -> tuple[int, int]:
    """Return the stud for the corner of an object whose middle comes nearest to a place, as it stood at first."""
    described = arrangement.described(name)
    pose = described.standing(upright(pose_of(described.first)), *at, plate.top)
    low = described.solid(pose).corners[:, :2].min(axis=0)
    found = []
    for corner, middle, count in zip(low, plate.place, plate.studs, strict=False):
        found.append(round((corner - middle) / plate.pitch + count / 2) + 1)
    return max(1, found[0]), max(1, found[1])


def _on_table(table: ObjectTable, at: Pair) -> None:
    if not table.is_free(*at):
        (x0, y0), (x1, y1) = ((round(1000 * x), round(1000 * y)) for x, y in table.area)
        raise OutOfWorkspace(
            f"That place is out of reach. {ELSEWHERE} The arm works from x {x0} to {x1} mm and y {y0} to {y1} mm."
        )


def _mm(at: Pair) -> Pair:
    return round(1000 * at[0], 3), round(1000 * at[1], 3)
