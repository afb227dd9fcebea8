"""Plans a whole task before anything moves: each step on the model of the objects, each motion with the arm's planner.

Pure: no clock, no wire. The same for the check of a task, its preview and its run.
"""

from collections.abc import Hashable, Iterable, Iterator
from dataclasses import replace
from math import inf, radians, remainder, tau

import numpy as np
from scipy.spatial.transform import Rotation

from robots.kit.arms.arrangement import Arrangement, NotPossible
from robots.kit.arms.budget import MOST, Budget
from robots.kit.arms.chain import Joints, Matrix
from robots.kit.arms.motions import MotionPlanner
from robots.kit.arms.objects import TABLE, DescribedObject, pose_of, upright, yaw_of
from robots.kit.arms.planner import Refused, in_words
from robots.kit.arms.plates import PLATE
from robots.kit.arms.pose import Six, matrix
from robots.kit.arms.tasks import steps
from robots.kit.arms.tasks.acts import Act, StepImpossible
from robots.kit.arms.tasks.steps import Step, Task
from robots.kit.arms.tasks.ways import Way, Ways
from robots.kit.description import load

LONGEST_S = 300.0  # of a whole task
WORK = MOST  # of the budget, for a whole task: as for a program
STEP, AGAIN = 80, 5  # of it: a step's own checks; a step that was planned from here before
SAME_M = 0.005  # of where the tool leaves an object, and where it came from
EXACT = 6  # decimals (m, rad) to which a step from here is the same as one before


def plan(planner: MotionPlanner, task: Task, arrangement: Arrangement, q: Joints) -> list[Act]:
    """Return what the arm does for a task, from rest at `q` (rad). Raises StepImpossible."""
    return list(acts(planner, task, arrangement, q))


def acts(planner: MotionPlanner, task: Task, arrangement: Arrangement, q: Joints) -> Iterator[Act]:
    """Yield what the arm does, one act after another, up to a step that cannot be done. Raises StepImpossible."""
    planned, total = _Planning(planner, arrangement, q), 0.0
    for number, step in enumerate(task.steps(), 1):
        planned.step, planned.of = number, step
        try:
            for act in planned.once():
                total += act.seconds
                if total > LONGEST_S:
                    raise Refused("range", f"the task would take longer than the {LONGEST_S:g} s that one may take")
                yield act
        except (Refused, NotPossible) as error:
            code = error.code if isinstance(error, Refused) else "objects"
            raise StepImpossible(code, number, step, total, str(error)) from error


class _Planning:
    """The state of a task that is tried: where the arm and the objects are after the steps so far."""

    def __init__(self, planner: MotionPlanner, arrangement: Arrangement, q: Joints) -> None:
        self.arrangement, self.step, self.of = arrangement, 0, Step(steps.Open())
        self._budget = Budget(WORK)
        self._ways = Ways(planner, q, self._budget)
        self._planned: dict[Hashable, tuple[list[Act], Joints, Arrangement]] = {}
        description = load(planner.driver)
        self._grip_s = float(description["gripper"].get("seconds", 1.0))
        self._postures = [name[:-4] for name in description["arm"] if name.endswith("_deg")]

    def once(self) -> Iterator[Act]:
        """Yield the acts of the present step; one that begins as a step before, in a repetition, is not planned again.

        Raises Refused, NotPossible.
        """
        key = self.of.action, *np.round(self._ways.q, EXACT).tolist(), *_key(self.arrangement)
        known = self._planned.get(key)
        with in_words():
            self._budget.spend(STEP if known is None else AGAIN)
        if known is not None:
            done, self._ways.q, self.arrangement = known
            yield from (replace(act, step=self.step, of=self.of) for act in done)
            return
        done = []
        for act in self.acts():
            done.append(act)
            yield act
        self._planned[key] = done, self._ways.q, self.arrangement

    def acts(self) -> Iterator[Act]:
        """Yield the acts of the present step. Raises Refused, NotPossible."""
        action = self.of.action
        match action:
            case steps.Grasp(name):
                yield from self._grasp(name)
            case steps.Feel(at):
                yield from self._feel((at[0] / 1000, at[1] / 1000))
            case steps.PutOn() | steps.PutAt():
                if self.arrangement.held is None:
                    yield from self._grasp(action.name)
                yield from self._put(action)
            case steps.MoveTo(place, angles):
                yield from self._moved(self._ways.travel(self._target(place, angles), self.arrangement))
            case steps.MovePosture(posture):
                if posture not in self._postures:
                    raise NotPossible(f"there is no posture {posture}; there are {', '.join(self._postures)}")
                yield from self._moved([self._ways.go(self._ways.posture(posture))])
            case steps.Open():
                yield from self._opened()
            case steps.Close():
                yield from self._closed()
            case steps.Wait(seconds):
                yield self._act("wait", {"seconds": seconds}, seconds)
            case _:
                self._expected(action)
                yield self._act("expect", {}, 0.0)

    def _act(self, kind: str, args: dict[str, float], seconds: float) -> Act:
        return Act(self.step, self.of, kind, args, self.arrangement, seconds)

    def _moved(self, ways: list[Way]) -> Iterator[Act]:
        for way in ways:
            yield Act(self.step, self.of, way.kind, way.args, self.arrangement, way.seconds, way.path)

    def _straight(self, to: Matrix) -> Iterator[Act]:
        if not self._ways.is_at(to):
            yield from self._moved([self._ways.go(self._ways.line(to, self.arrangement.table.slow))])

    def _target(self, place: steps.Three, angles: steps.Three | None) -> Matrix:
        """Return the pose of `move`. Raises nothing: the planner refuses what cannot be reached."""
        x, y, z = (v / 1000 for v in place)
        if angles is None:
            pose = self._ways.tool
            pose[:3, 3] = x, y, z
            return pose
        a, b, c = (radians(v) for v in angles)
        six: Six = x, y, z, a, b, c
        return matrix(six)

    def _grasp(self, name: str) -> Iterator[Act]:
        self.arrangement.check_grasp(name)
        described, pose = self.arrangement.described(name), self.arrangement.pose(name)
        yield from self._first(
            self._grasp_by(name, pose @ _turned(turn) @ grasp.tool, pose[:3, :3] @ _turned(turn)[:3, :3] @ grasp.away)
            for grasp in described.grasps
            for turn in _turns(described, 0.0)
        )

    def _feel(self, at: tuple[float, float]) -> Iterator[Act]:
        """Close the gripper on the table, as for an object that stands there as its kind does at first."""
        described = next(iter(self.arrangement.table.objects.values()))
        pose = described.standing(pose_of(described.first)[:3, :3], *at, self.arrangement.table.height)
        yield from self._first(
            self._feel_by(pose @ _turned(turn) @ grasp.tool, pose[:3, :3] @ _turned(turn)[:3, :3] @ grasp.away)
            for grasp in described.grasps
            for turn in _turns(described, 0.0)
        )

    def _feel_by(self, tool: Matrix, away: Matrix) -> Iterator[Act]:
        self.arrangement.check_fingers(tool)
        yield self._act("gripper", {"closed": 0.0}, self._grip_s)
        yield from self._moved(self._ways.travel(_shifted(tool, away), self.arrangement))
        yield from self._straight(tool)
        yield self._act("gripper", {"closed": 1.0}, self._grip_s)
        yield from self._straight(_shifted(tool, (0.0, 0.0, self.arrangement.table.lift)))

    def _first(self, ways: Iterable[Iterator[Act]]) -> Iterator[Act]:
        """Yield the acts of the first way to do a step that can be gone.

        Raises NotPossible for the reason of the first way where none can, and what a way raises once nothing more may
        be planned.
        """
        begun, refusal = self._ways.q, ""
        for way in ways:
            try:
                found = list(way)
            except (Refused, NotPossible) as error:
                if self._budget.remaining < 0:
                    raise
                refusal, self._ways.q = refusal or str(error), begun
            else:
                yield from found
                return
        raise NotPossible(refusal)

    def _grasp_by(self, name: str, tool: Matrix, away: Matrix) -> Iterator[Act]:
        """Yield the acts of one way to take an object; nothing is changed but the arm's place. Raises as `acts`."""
        self.arrangement.check_fingers(tool, name)
        before = self.arrangement
        after = before.with_held(name, tool)
        try:
            yield self._act("gripper", {"closed": 0.0}, self._grip_s)
            yield from self._moved(self._ways.travel(_shifted(tool, away), before))
            yield from self._straight(tool)
            self.arrangement = after
            yield self._act("gripper", {"closed": 1.0}, self._grip_s)
            yield from self._straight(_shifted(tool, (0.0, 0.0, before.table.lift)))
        except (Refused, NotPossible):
            self.arrangement = before
            raise

    def _put(self, action: steps.PutOn | steps.PutAt) -> Iterator[Act]:
        name, load_now = action.name, self.arrangement.load()
        if load_now is None or load_now[0] != name:
            self.arrangement.described(name)
            raise NotPossible(f"the gripper holds {load_now[0] if load_now else 'nothing'}, not {name}")
        described, grip = self.arrangement.described(name), load_now[1]
        yield from self._first(
            self._put_by(name, pose, pose @ np.linalg.inv(grip)) for pose in self._poses(action, described, grip)
        )

    def _put_by(self, name: str, pose: Matrix, tool: Matrix) -> Iterator[Act]:
        """Yield the acts by which an object is put; as `_grasp_by`."""
        self.arrangement.check_place(name, pose)
        before, table = self.arrangement, self.arrangement.table
        after = before.with_place(name, pose)
        after.check_fingers(tool, name)
        opens, above = (_shifted(tool, (0.0, 0.0, up)) for up in (table.release, table.lift))
        leaves = _shifted(opens, self._away(name, pose, tool))
        if np.abs(leaves - above).max() < SAME_M:  # back by the way that it came, which needs no plan
            leaves = above
        try:
            yield from self._moved(self._ways.travel(above, before))
            yield from self._straight(opens)
            self.arrangement = after
            yield self._act("gripper", {"closed": 0.0}, self._grip_s)
            yield from self._straight(leaves)
        except (Refused, NotPossible):
            self.arrangement = before
            raise

    def _away(self, name: str, pose: Matrix, tool: Matrix) -> Matrix:
        """Return the way (m) by which the tool leaves an object: that of the grasp that is most like how it is held."""
        described = self.arrangement.described(name)
        held, best, nearest = np.linalg.inv(pose) @ tool, np.zeros(3), inf
        for grasp in described.grasps:
            for turn in _turns(described, 0.0):
                apart = float(np.abs(_turned(turn) @ grasp.tool - held).max())
                if apart < nearest:
                    nearest, best = apart, pose[:3, :3] @ _turned(turn)[:3, :3] @ grasp.away
        return np.asarray(best)

    def _poses(self, action: steps.PutOn | steps.PutAt, described: DescribedObject, grip: Matrix) -> Iterator[Matrix]:
        """Yield the poses at which an object may be put, that with the least turn first. Raises NotPossible."""
        now = self._ways.tool @ grip
        if isinstance(action, steps.PutOn):
            if action.on == TABLE:
                raise NotPossible("say where on the table: put A at X Y")
            if action.on == action.name:
                raise NotPossible(f"{action.name} cannot lie on itself")
            yaw = yaw_of(self.arrangement.bearing(action.on)[0]) + radians(action.turned or 0.0)
        else:
            yaw = yaw_of(now) if action.yaw is None else radians(action.yaw)
        for turn in _turns(described, remainder(yaw_of(now) - yaw, tau)):
            rotation = upright(now, yaw + turn)
            if isinstance(action, steps.PutOn):
                dx, dy = (v / 1000 for v in action.by or (0.0, 0.0))
                yield self.arrangement.on_top(action.name, rotation, action.on, (dx, dy), action.stud)
            else:
                x, y = (v / 1000 for v in action.at)
                yield described.standing(rotation, x, y, self.arrangement.table.height)

    def _opened(self) -> Iterator[Act]:
        load_now = self.arrangement.load()
        if load_now is not None:
            name, grip = load_now
            self.arrangement = self.arrangement.with_place(name, self.arrangement.settled(name, self._ways.tool @ grip))
        yield self._act("gripper", {"closed": 0.0}, self._grip_s)

    def _closed(self) -> Iterator[Act]:
        name = None if self.arrangement.held else self.arrangement.between_fingers(self._ways.tool)
        if name is not None:
            self.arrangement = self.arrangement.with_held(name, self._ways.tool)
        yield self._act("gripper", {"closed": 1.0}, self._grip_s)

    def _expected(self, action: steps.Action) -> None:
        check_expected(action, self.arrangement)


def check_expected(action: steps.Action, arrangement: Arrangement) -> None:
    """Refuse where what `expect` says is not so, by the model. Raises NotPossible."""
    match action:
        case steps.ExpectOn(name, on):
            if on not in (TABLE, PLATE):
                arrangement.described(on)
            beneath = arrangement.beneath(name)
            if on not in beneath:
                raise NotPossible(f"{name} lies on {', '.join(beneath) or 'nothing'}")
        case steps.ExpectHeld(None):
            if arrangement.held is not None:
                raise NotPossible(f"the gripper holds {arrangement.held}")
        case steps.ExpectHeld(name) if name is not None:
            arrangement.described(name)
            if arrangement.held != name:
                raise NotPossible(f"the gripper holds {arrangement.held or 'nothing'}")
        case _:
            pass


def _key(arrangement: Arrangement) -> Iterator[Hashable]:
    for name, placed in sorted(arrangement.places.items()):
        numbers = (*placed.place, *placed.rotation)
        yield name, placed.held, *(round(v, EXACT) + 0.0 for v in numbers)


def _turns(described: DescribedObject, now: float) -> list[float]:
    """Return the turns (rad) after which an object looks the same, that nearest to `now` first."""
    turns = [n * tau / described.turns for n in range(described.turns)]
    return sorted(turns, key=lambda turn: round(abs(remainder(turn - now, tau)), 9))


def _turned(turn: float) -> Matrix:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("z", turn).as_matrix()
    return pose


def _shifted(pose: Matrix, by: "Matrix | tuple[float, float, float]") -> Matrix:
    moved = pose.copy()
    moved[:3, 3] += by
    return moved
