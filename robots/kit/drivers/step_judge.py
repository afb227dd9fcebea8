"""Judges the steps of a task by fresh pictures, for an arm that has eyes: without them, by what is believed.

Pictures that show nothing change nothing: the task goes on by belief, and says so.
"""

from collections.abc import Callable, Mapping

from robots.kit.arms.arrangement import Arrangement, NotPossible
from robots.kit.arms.beliefs import How, ObjectModel
from robots.kit.arms.chain import Matrix
from robots.kit.arms.tasks import steps
from robots.kit.arms.tasks.acts import Act
from robots.kit.arms.tasks.planning import check_expected
from robots.kit.drivers import sights
from robots.kit.drivers.arm_eyes import Sight

Look = Callable[[bool, Mapping[str, Matrix]], Sight | None]  # whether it insists, where objects may be too
Tool = Callable[[], Matrix]
Tell = Callable[[str], None]
BELIEVED = "Judged by what is believed, because it could not look: {}."
NOT_SEEN = "the pictures do not show where {} is"


class StepJudge:
    """`look` takes over what it sees and returns it, None for an arm without eyes; `tool` is where the tool is."""

    def __init__(self, model: ObjectModel, look: Look, tool: Tool) -> None:
        self._model, self._look, self._tool = model, look, tool
        self.sees = False  # whether the newest look has shown something
        self._told = False

    def begin(self) -> None:
        """Begin a task."""
        self._told = False

    def lifted(self, act: Act, first: Arrangement, tell: Tell) -> bool:
        """Look at what was lifted by an act, in a step that has begun with the objects `first`.

        Returns whether something was seen. Raises NotPossible where the gripper is seen to be empty.
        """
        load = act.arrangement.load()
        if load is not None:
            held = self._tool() @ load[1]
            if (sight := self._seen({load[0]: first.pose(load[0])}, tell)) is not None:
                sights.check_in_hand(load[0], sight, held)
        return self.sees

    def after(self, act: Act, tell: Tell) -> None:
        """Look at what a step has done, after its last act. Raises NotPossible."""
        action = act.of.action
        if isinstance(action, steps.Grasp | steps.ExpectOn | steps.ExpectHeld):
            return  # it has looked
        if (sight := self._seen({}, tell)) is not None and isinstance(action, steps.PutOn | steps.PutAt):
            on_other = isinstance(action, steps.PutOn)
            sights.check_put(action.name, sight, act.arrangement.pose(action.name), on_other)

    def _seen(self, or_at: Mapping[str, Matrix], tell: Tell) -> Sight | None:
        """Return what is seen; None where there are no eyes. That they see nothing is told once."""
        sight = self._look(False, or_at)
        self.sees = sight is not None and not sight.blind
        if sight is not None and sight.blind and not self._told:
            self._told = True
            tell(BELIEVED.format(sight.blind))
        return sight

    def expected(self, action: steps.Action, tell: Tell) -> None:
        """Refuse where what `expect` says is not so, by a fresh picture where one shows it. Raises NotPossible."""
        sight = self._look(True, {})
        if sight is not None:
            for name in steps.names(action):
                if self._model.belief(name).how == How.UNSEEN:
                    raise NotPossible(f"the pictures do not show {name} where it was")
                if sight.blind or name not in sight.noticed:
                    tell(BELIEVED.format(sight.blind or NOT_SEEN.format(name)))
                    break
        check_expected(action, self._model.arrangement)
