"""What people ask of an arm with objects: a task, and staff's correction of a place. Checks and previews, pure.

A spec takes `task_commands` and `task_capabilities`, a driver's check calls `check_request`.
"""

from collections.abc import Iterable
from math import tau
from typing import Any

import numpy as np

from robots.kit.arms.arrangement import Arrangement
from robots.kit.arms.described import posture
from robots.kit.arms.motions import MotionPlanner
from robots.kit.arms.object_streams import OBJECTS
from robots.kit.arms.objects import TABLE, ObjectTable, objects_of, placed_of, pose_of, upright
from robots.kit.arms.plates import PLATE
from robots.kit.arms.preview import Trail, start_of
from robots.kit.arms.tasks import steps
from robots.kit.arms.tasks.acts import StepImpossible
from robots.kit.arms.tasks.parsing import LONGEST_TEXT, BadTask, parse
from robots.kit.arms.tasks.picking import LONGEST_S as LONGEST_STEP_S
from robots.kit.arms.tasks.picking import PICK, PUT, picking, picking_commands, task_at
from robots.kit.arms.tasks.planning import LONGEST_S, acts, plan
from robots.kit.arms.tasks.steps import Task
from robots.kit.contract.capabilities import Foreseen, JobCheck, Judgement, Objects, Programs
from robots.kit.contract.errors import BadRequest, OutOfWorkspace
from robots.kit.contract.objects import KnownObjects, Placed
from robots.kit.contract.spec import ANYONE, STAFF, TURN, Argument, CommandKind
from robots.kit.contract.tidying import LONGEST_S as LONGEST_TIDY_S
from robots.kit.contract.tidying import Tidy
from robots.kit.contract.values import number
from robots.kit.description import load

TASK, AMEND, TIDY = "task", "amend", "tidy"
KINDS = (TASK, PICK, PUT, AMEND, TIDY)
FORESEEN = (TASK, PICK, PUT)  # kinds with a preview by the objects
Packets = Iterable[tuple[bytes, bool]]


def task_commands(table: ObjectTable) -> tuple[CommandKind, ...]:
    """Return the commands of an arm with objects: `task`, `pick` and `put`, and `amend` for staff."""
    ends = zip("xyz", table.box.low, table.box.size, strict=True)
    place = tuple(Argument(name, "m", low, low + size) for name, low, size in ends)
    text = Argument("text", "", 1, LONGEST_TEXT, text=True, label="steps, one a line")
    numbers = ", ".join(f"{one.number} {name}" for name, one in table.objects.items())
    which = Argument("object", "", 0, len(table.objects) - 1, whole=True, help=f"{numbers}.")
    return (
        CommandKind(TASK, "Task", (text,), limit_s=LONGEST_S, asked_by=frozenset({TURN, ANYONE})),
        *picking_commands(table),
        CommandKind(
            AMEND, "Correct an object's place", (which, *place, Argument("yaw", "rad", -tau, tau)), limit_s=10.0,
            lane="config", asked_by=frozenset({STAFF}), moves=False, still_after=False,
        ),
    )  # fmt: skip


def tidy_commands(driver: str) -> tuple[CommandKind, ...]:
    """Return the command that brings the objects back; none for an arm that cannot see where they are."""
    most = Argument("seconds", "s", 1.0, LONGEST_TIDY_S, required=False)
    one = CommandKind(
        TIDY, "Tidy the table", (most,), limit_s=LONGEST_TIDY_S + 2 * LONGEST_STEP_S, asked_by=frozenset({STAFF})
    )
    return (one,) if has_eyes(driver) else ()


def has_eyes(driver: str) -> bool:
    """Return whether an arm sees its objects: calibrated cameras, and markers or colours."""
    description = load(driver)
    return "view" in description and bool({"markers", "colours"} & description.keys())


def task_capabilities(driver: str, job_check: str) -> tuple[Any, ...]:
    """Return the capabilities of an arm with objects; `job_check` is a function as `JobCheck` names it."""
    return (
        Programs(TASK, "steps with objects"), JobCheck(OBJECTS, job_check), Objects(OBJECTS, objects_of(driver).box),
        picking(driver), *((Tidy(TIDY), Tidy(TIDY).setting) if has_eyes(driver) else ()),
    )  # fmt: skip


def task_of(driver: str, arrangement: Arrangement, kind: str, args: dict[str, Any]) -> Task:
    """Return what a command of `FORESEEN` does, with the objects as they are. Raises BadRequest, OutOfWorkspace."""
    return parsed(args["text"]) if kind == TASK else task_at(driver, arrangement, kind, args)


def parsed(text: str) -> Task:
    """Return the task of a text. Raises BadRequest."""
    try:
        return parse(text)
    except BadTask as error:
        raise BadRequest(str(error)) from error


def check_request(table: ObjectTable, kind: str, args: dict[str, Any]) -> None:
    """Refuse a text that is no task, and names of objects that are not there. Raises BadRequest."""
    steps_of = parsed(args["text"]).steps() if kind == TASK else ()
    surfaces = (TABLE,) if table.plate is None else (TABLE, PLATE)
    for step in steps_of:
        for name in steps.names(step.action, surfaces):
            if table.named(name) is None:
                written = ", ".join(table.objects)  # as tasks name them, in all languages
                raise BadRequest(f"Line {step.line}: there is no object {name}; there are {written}.")


def amendment(table: ObjectTable, args: dict[str, Any]) -> tuple[str, Placed]:
    """Return the object and the place that `amend` says: upright as at first, turned about the vertical by `yaw`."""
    wanted = int(number(args, "object"))
    described = next(one for one in table.objects.values() if one.number == wanted)
    pose = pose_of(described.first)
    pose[:3, :3] = upright(pose, number(args, "yaw"))
    pose[:3, 3] = [number(args, name) for name in "xyz"]
    return described.name, placed_of(pose)


def arrangement_of(table: ObjectTable, packets: Packets) -> Arrangement:
    """Return where the objects are by the packets of their stream; at first, where none is known or can be read."""
    known, places = KnownObjects(table.box), dict(table.first())
    try:
        read = [known.take(data, key).objects for data, key in packets]
    except ValueError:
        read = []
    if read:
        places = {name: read[-1][one.number] for name, one in table.objects.items() if one.number in read[-1]}
    return Arrangement(table, places)


def check_job(planner: MotionPlanner, table: ObjectTable, args: dict[str, Any], packets: Packets) -> None:
    """Refuse a task as a job that cannot be done from the arm's ready posture, with the objects as they are now.

    Raises:
        BadRequest: the text is no task. OutOfWorkspace: names the line and the cause.
    """
    ready = np.array(posture(load(planner.driver), "ready"))
    try:
        plan(planner, parsed(args["text"]), arrangement_of(table, packets), ready)
    except StepImpossible as error:
        raise OutOfWorkspace(str(error)) from error


def foresee_task(
    planner: MotionPlanner,
    table: ObjectTable,
    kind: str,
    args: dict[str, Any],
    joints: tuple[float, ...],
    packets: Packets,
) -> Foreseen:
    """Return where a command of `FORESEEN` would lead from rest at `joints` (rad).

    Raises:
        BadRequest: the text is no task, or `joints` cannot be those of the arm.
        OutOfWorkspace: it cannot be done. A step of a text that cannot be done has a judgement that refuses it instead.
    """
    here, arrangement = start_of(planner.driver, joints), arrangement_of(table, packets)
    task = task_of(planner.driver, arrangement, kind, args)
    trail = Trail(here)
    judgements: tuple[Judgement, ...] = ()
    try:
        for act in acts(planner, task, arrangement, here):
            trail.add(act.step, act.seconds, act.path)
    except StepImpossible as error:
        if not error.line:
            raise OutOfWorkspace(str(error)) from error
        judgements = (Judgement(error.step, error.at_s, str(error)),)
    return trail.foreseen(planner, numbered=kind == TASK, judgements=judgements)
