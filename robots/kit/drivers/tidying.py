"""Brings the objects around an arm back to their first places, by its own tasks of one step each.

Before each step it looks from where the arm hides nothing, and moves only what it sees. Every step is planned and
checked as any other. What cannot be done is left, and said.
"""

from collections import Counter
from collections.abc import Callable, Mapping
from math import degrees, radians

from robots.kit.arms.beliefs import ObjectModel
from robots.kit.arms.chain import Matrix
from robots.kit.arms.pose import numbers
from robots.kit.arms.tasks.acts import StepImpossible
from robots.kit.arms.tasks.steps import MoveTo, Step, Task
from robots.kit.arms.tasks.tidying import Move, displaced, moves
from robots.kit.clock import Limit
from robots.kit.contract.errors import GaveUp, OutOfWorkspace
from robots.kit.contract.session import OnStage, Permit, Progress, Session
from robots.kit.drivers.arm_eyes import Sight
from robots.kit.drivers.permits import until_held
from robots.kit.drivers.task_runner import TaskRunner

MOVE_S = 30.0  # that one object may take
MOST_TRIES = 2  # of an object, where the arm itself has failed
# how near to its first place (m, rad) an object is there, by what eyes can tell
NEAR_EXACT, NEAR_ROUGH = (0.005, radians(5.0)), (0.015, radians(20.0))
NO_EYES = "this arm has no cameras that show it objects"
UNSEEN = "the pictures do not show it"
COVERED = "something lies on it, or where it belongs"
NO_TIME = "there was no time left for it"
NOT_THERE = "the pictures do not show it where it was put"
LEFT = "{} was not brought back: {}."
OTHERS = "The others are in their places."
NOT_BEGUN = "The table was not tidied: {}."
Look = Callable[[], Sight | None]


class Tidying:
    """Tidies once. `ready` is the tool's pose (4 x 4) from which the arm hides nothing; `rough`: eyes by colours."""

    def __init__(
        self, session: Session, model: ObjectModel, runner: TaskRunner, look: Look, holds: Callable[[], int],
        ready: Matrix, rough: bool,
    ) -> None:  # fmt: skip
        self._session, self._model, self._runner, self._look, self._holds = session, model, runner, look, holds
        a, b, c, *angles = numbers(ready)
        roll, pitch, yaw = map(degrees, angles)
        self._away = MoveTo((1000 * a, 1000 * b, 1000 * c), (roll, pitch, yaw))
        self._near = NEAR_ROUGH if rough else NEAR_EXACT
        self._tries: Counter[str] = Counter()
        self._aside: set[str] = set()
        self._why: dict[str, str] = {}

    def run(self, seconds: float, permit: Permit, on_stage: OnStage) -> None:
        """Bring back what is elsewhere.

        Raises:
            GaveUp: something was left; a sentence for each object says why. The arm is at rest.
            And what `Session.execute` raises.
        """
        limit = Limit(self._session.clock, seconds)
        free = until_held(permit, self._holds)
        free()
        for stage in ("sent", "acknowledged"):
            on_stage(stage)
        while True:
            sight = self._seen(free)
            left = self._left(on_stage)
            if not left or not (goes_on := self._one(sight, left, limit, permit, free)):
                break
            free = goes_on
        if left:
            raise GaveUp(self._sentences(left))

    def _seen(self, free: Permit) -> Sight:
        """Look from where the arm hides nothing. Raises GaveUp where it sees nothing."""
        try:
            self._do(Task((Step(self._away),)), free)
        except OutOfWorkspace as error:
            raise GaveUp(NOT_BEGUN.format(_cause(error))) from error
        free()
        sight = self._look()
        if sight is None or sight.blind:
            raise GaveUp(NOT_BEGUN.format(NO_EYES if sight is None else sight.blind))
        return sight

    def _left(self, on_stage: OnStage) -> Mapping[str, str]:
        """Return the objects that are not where they belong, each with why; tell how far it is."""
        arrangement, objects = self._model.arrangement, self._model.table.objects
        off = displaced(arrangement, self._near)
        known = arrangement.places
        left = {
            name: COVERED if name in known else UNSEEN
            for name, one in objects.items()
            if name in off or (name not in known and not one.hangs)
        }
        there = len(objects) - len(left)
        on_stage(Progress(f"{there} of {len(objects)} are in their places", there / len(objects)))
        return left

    def _one(self, sight: Sight, left: Mapping[str, str], limit: Limit, permit: Permit, free: Permit) -> Permit | None:
        """Carry out the first move that can be; return the permit for what comes next, None where none can be."""
        for move in moves(self._model.arrangement, self._near, self._aside):
            name = move.name
            if self._tries[name] >= MOST_TRIES:
                continue
            if name not in sight.noticed and name != self._model.held:
                self._why[name] = UNSEEN
                continue
            if limit.remaining < MOVE_S:
                self._why.update(dict.fromkeys(left, NO_TIME))
                return None
            free()
            try:
                self._do(Task((Step(move.action),)), free)
            except OutOfWorkspace as error:
                self._why[name] = _cause(error)
            except GaveUp as error:
                self._failed(move, str(error))
                return until_held(permit, self._holds)  # the arm was held by the task itself
            else:
                self._done(move)
                return free
        return None

    def _failed(self, move: Move, why: str) -> None:
        self._tries[move.name] += 1
        self._why[move.name] = _clause(why)

    def _done(self, move: Move) -> None:
        if move.aside:
            self._aside.add(move.name)
            self._why.pop(move.name, None)
        else:
            self._failed(move, NOT_THERE)  # unless it is seen there

    def _do(self, task: Task, free: Permit) -> None:
        self._runner.run(lambda _: task, free, lambda _: None, lambda: None)

    def _sentences(self, left: Mapping[str, str]) -> str:
        said = [LEFT.format(name[:1].upper() + name[1:], self._why.get(name, why)) for name, why in left.items()]
        if len(left) < len(self._model.table.objects):
            said.append(OTHERS)
        return " ".join(said)


def _cause(error: OutOfWorkspace) -> str:
    return error.__cause__.why if isinstance(error.__cause__, StepImpossible) else _clause(str(error))


def _clause(sentence: str) -> str:
    return f"{sentence[:1].lower()}{sentence[1:]}".rstrip(".")
