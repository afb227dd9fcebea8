"""Takes an object that swings on threads: where it turns, because it is slowest there, and at that moment."""

import itertools
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from robots.kit.arms.arrangement import NotPossible
from robots.kit.arms.beliefs import How, ObjectModel
from robots.kit.arms.budget import MOST, Budget
from robots.kit.arms.chain import Joints, Matrix
from robots.kit.arms.described import boxes, limbs
from robots.kit.arms.motions import MotionPlanner
from robots.kit.arms.objects import placed_of, pose_of
from robots.kit.arms.swing import Swing, fitted, height
from robots.kit.arms.tasks.acts import Act, StepImpossible
from robots.kit.arms.tasks.planning import plan
from robots.kit.arms.tasks.steps import Step, Task
from robots.kit.arms.tasks.ways import Ways
from robots.kit.arms.zones import Zones
from robots.kit.clock import Limit, Timer
from robots.kit.contract.session import Permit
from robots.kit.description import load

STILL_M, FARTHEST_M = 0.008, 0.08  # to each side: so little counts as rest; more cannot be caught
OFF_M = 0.006  # of the places that were seen from those of a pendulum: more, and what it will do is not known
WATCHED_S, BETWEEN_S = 2.4, 0.15  # nearly one swing; between two pictures
RESTS_S, RESTS_M = 0.6, 0.0015  # what is seen to move less in so long does not swing: at a turn it would by a quarter
QUICK = 1.0  # share of full speed of the last way
LEAD_S = 0.15  # from the command of a motion to its begin
GRIP_S = 0.1  # from the end of the way to the middle of the time in which the fingers close

Glance = Callable[[str], tuple[float, Matrix | None] | None]  # see `ArmEyes.glance`


class Catch:
    """One attempt to take an object that swings. `approach`: the acts until the tool waits above where it turns."""

    def __init__(
        self, clock: Timer, model: ObjectModel, glance: Glance, planner: MotionPlanner, of: Step, name: str
    ) -> None:
        self._clock, self._model, self._glance = clock, model, glance
        self._planner, self._of, self._name = planner, of, name
        self.approach: list[Act] = []
        self._rest: list[Act] = []
        self._side = np.zeros(2)

    def watch(self, permit: Permit) -> Swing | None:
        """Look at the object for nearly one swing; None where it rests, or is not seen. Raises NotPossible."""
        threads = self._model.table.objects[self._name].threads
        assert threads is not None, "nobody asks for what cannot swing"
        until, times, places = Limit(self._clock, WATCHED_S), list[float](), list[Matrix]()
        for count in itertools.count():
            permit()
            if (seen := self._glance(self._name)) is None:
                if count > 1 and not times:
                    return None  # there are no pictures
            elif seen[1] is not None:
                times.append(seen[0])
                places.append(seen[1][:3, 3])
                self._model.place(self._name, placed_of(seen[1]), How.MEASURED)
            if len(times) > 2 and times[-1] - times[0] > RESTS_S and np.ptp(places, axis=0).max() < RESTS_M:
                return None
            if until.over:
                break
            self._clock.sleep(BETWEEN_S)
        return self._judged(fitted(times, places, threads[0]))

    def _judged(self, swing: Swing | None) -> Swing | None:
        """Return a swing that can be caught, None for rest. Raises NotPossible."""
        if swing is None:
            raise NotPossible(
                f"{self._name} is not seen where it hangs, so it may swing too far to be caught; "
                "wait until it swings less"
            )
        if swing.far < STILL_M:
            return None
        if swing.far > FARTHEST_M:
            raise NotPossible(
                f"{self._name} swings by {1000 * swing.far:.0f} mm to each side, and is caught at most at "
                f"{1000 * FARTHEST_M:.0f}; wait until it swings less"
            )
        if swing.off > OFF_M:
            raise NotPossible(f"{self._name} does not swing evenly, so when it turns is not known; wait a while")
        return swing

    def begin(self, swing: Swing, q: Joints) -> None:
        """Plan from joints (rad) to above one of the two places where it turns. Raises NotPossible."""
        refusal = ""
        for side in (1.0, -1.0):
            try:
                self._plan(swing, side, q)
            except (NotPossible, StepImpossible) as error:
                refusal = refusal or (error.why if isinstance(error, StepImpossible) else str(error))
            else:
                return
        raise NotPossible(refusal)

    def _plan(self, swing: Swing, side: float, q: Joints) -> None:
        there = self._turned(swing.middle + side * swing.far * swing.way)
        arrangement = self._model.arrangement.with_place(self._name, there)
        acts = plan(self._planner, Task((self._of,)), arrangement, q)
        self._check_threads(acts, swing)
        closes = next(n for n, act in enumerate(acts) if act.kind == "gripper" and act.args["closed"])
        self.approach, self._rest, self._side = acts[: closes - 1], acts[closes - 1 :], side * swing.way

    def _turned(self, at: Matrix) -> Matrix:
        """Return the pose (4 x 4) of the object where it turns (x, y), which is a little higher than where it rests."""
        described = self._model.table.objects[self._name]
        pose = pose_of(described.first)
        if described.threads is not None:
            pose[2, 3] = height(described.threads[0], pose[:3, 3], at)
        pose[:2, 3] = at
        return pose

    def _check_threads(self, acts: list[Act], swing: Swing) -> None:
        """Refuse ways on which the arm would come to where the threads swing. Raises NotPossible."""
        described, description = self._model.table.objects[self._name], load(self._planner.driver)
        reach = np.abs(swing.far * swing.way)
        names = described.threads[1] if described.threads else ()
        swept = [
            replace(
                box, low=(box.low[0] - reach[0], box.low[1] - reach[1], box.low[2]),
                high=(box.high[0] + reach[0], box.high[1] + reach[1], box.high[2]),
            )
            for box in boxes(description) if box.name in names
        ]  # fmt: skip
        chain = self._planner.planner.chain
        zones = Zones(chain, limbs(description, chain), swept).widened(description["motion"]["clearance_m"])
        for act in acts:
            if act.path is not None and (found := zones.swept(act.path)) is not None:
                raise NotPossible(f"on the way {found[1]}, which swings with {self._name}")

    def last(self, q: Joints, permit: Permit) -> list[Act]:
        """Return the acts from above it until it is lifted, the first one a wait for the right moment.

        Raises NotPossible where it swings otherwise now.
        """
        down, grips, *lifts = self._rest
        swing = self.watch(permit)
        if swing is None:
            raise NotPossible(f"{self._name} was not seen to swing any more")
        tool = pose_of(grips.arrangement.places[self._name])  # in the tool's frame
        ways = Ways(self._planner, q, Budget(MOST))
        goal = self._turned(swing.middle + swing.far * np.sign(swing.way @ self._side) * swing.way)
        way = ways.line(goal @ np.linalg.inv(tool), QUICK)
        ahead = LEAD_S + way.seconds + GRIP_S
        at, place = swing.turns(self._clock.monotonic() + ahead)
        if (place - swing.middle) @ self._side < 0.0:
            at, place = swing.turns(at + 0.1)
        waits = at - ahead - self._clock.monotonic()
        first = replace(down, kind="wait", args={"seconds": max(0.0, waits)}, seconds=waits, path=None)
        return [first, replace(down, args=way.args, path=way.path, seconds=way.seconds), grips, *lifts]
