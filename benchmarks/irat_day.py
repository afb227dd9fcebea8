"""A day of the iRat: every 50 s somebody clicks at random in the map, as the paper's own script did for its Table 1.

The driver's and the brain's code run in the simulated maze (`tests/irat_trial.py`). Judged by the robot's own map, as in the
paper; where the robot really was is known from the simulator alone. `HOURS`, `SEED`, `PRUNING` (0 or 1) choose the day.
"""

import os
import random
import tempfile
import time
from collections import Counter, deque
from math import hypot
from pathlib import Path

from benchmarks.stage import percentile, tell
from robots.kit.contract.errors import BadRequest, GaveUp, MotionHeld, RobotError
from robots.kit.contract.session import JSON
from robots.kit.description import load
from robots.kit.drivers.irat.brain.messages import Care
from robots.kit.drivers.irat.brain.places import IN_DOCK, MapCleared, goal_place
from simulators.irat.simulator import LIVE_S
from tests.irat_trial import Trial, place, silent

HOURS, SEED, PRUNING = (
    float(os.environ.get("HOURS", "24")),
    int(os.environ.get("SEED", "1")),
    os.environ.get("PRUNING", "0") == "1",
)
CLICK_S, QUEUE = 50.0, 10
TRUE_M = 0.25
PAPER = {"goals": 676, "reached": 447, "metres": 199, "recharges": 7, "cleared": 61}
GOAL, GOAL_PRUNING, TIMES = 0.80, 0.95, 24.0
CLEARED = (45, 80)  # maps a day, where they are not pruned


class Day:
    """Goals, needs and exploring in the paper's order: recharging, goals, exploration."""

    def __init__(self, folder: Path) -> None:
        self.trial = Trial(folder, SEED, width=208)
        self.trial.brain.call(lambda n: Care(n, PRUNING))
        self._low = float(load("irat")["battery"]["low"])
        self.goals: deque[JSON] = deque()
        self.count: Counter[str] = Counter()
        self.apart: list[float] = []
        self._dice, self._clicked = random.Random(SEED), 0.0
        self._maps: set[int] = set()
        self.flat = 0  # 1 once the battery was flat
        self.lowest = 1.0  # share of the battery's charge
        self.spent: Counter[str] = Counter()
        self.trial.each_step = self._visitors

    def run(self, seconds: float) -> None:
        """Let so many seconds of the robot's time pass; tell each hour how it goes."""
        hour = 0
        while self.trial.now < seconds:
            if self.trial.now >= 3600 * (hour + 1):
                hour = int(self.trial.now // 3600)
                spent = {name: round(s) for name, s in self.spent.items()}
                places = self.trial.brain.mind.slam.map.count
                print(
                    f"hour {hour}: {dict(self.count)}, {len(self.goals)} wait, {spent} s, {places} places, "
                    f"{time.process_time() / 60:.0f} CPU minutes", flush=True,
                )  # fmt: skip
            before = self.trial.now
            doing = "charge" if self._needs else "goal" if self.goals else "explore"
            try:
                {"charge": self._charge, "goal": self._goal, "explore": self._explore}[doing]()
            except MotionHeld:
                self.count[f"{doing} cut short"] += 1
            except RobotError as error:
                self.count[f"{doing}: {error}"[:60]] += 1
                self.trial.sleep(1.0)
            self.spent[doing] += self.trial.now - before

    @property
    def _needs(self) -> bool:
        """Tell whether the battery is low."""
        return self.trial.senses.share < self._low

    def _visitors(self) -> None:
        self._maps.add(self.trial.brain.mind.slam.map_number)
        charge = self.trial.world.battery.charge
        self.flat += int(charge < LIVE_S <= self.lowest)
        self.lowest = min(self.lowest, charge)
        if self.trial.now - self._clicked < CLICK_S:
            return
        self._clicked += CLICK_S
        held = self.trial.brain.mind.slam
        if not held.map.count:
            return
        self.count["clicks"] += 1
        known = held.map.poses[: held.map.count, :2]
        x, y = (
            self._dice.uniform(float(low), float(high)) for low, high in zip(known.min(0), known.max(0), strict=True)
        )
        try:
            found = goal_place(self.trial.brain.mind.map_shown(), held.map_number, x, y)
        except BadRequest as error:
            self.count["clicks at the dock"] += str(error) == IN_DOCK
            return
        if len(self.goals) < QUEUE:
            self.count["goals"] += 1
            self.goals.append(place(self.trial, found))

    def _stop_if(self, over: bool) -> None:
        if over:
            raise MotionHeld("Something else comes first.")

    def _explore(self) -> None:
        self.trial.roaming.explore(lambda: self._stop_if(bool(self.goals) or self._needs), silent)

    def _goal(self) -> None:
        goal = self.goals.popleft()
        try:
            self.trial.roaming.goal(goal, lambda: self._stop_if(self._needs), silent)
        except MotionHeld:
            self.goals.appendleft(goal)
            raise
        except GaveUp:
            self.count["given up"] += 1
        except MapCleared:
            self.count["dropped"] += 1
        except BadRequest as error:
            self.count[f"refused: {error}"] += 1
        else:
            self.count["reached"] += 1
            was, here = self.trial.truth.get(int(goal["experience"])), self.trial.world.plant.pose
            if was is not None:
                self.apart.append(hypot(was[0] - here[0], was[1] - here[1]))

    def _charge(self) -> None:
        try:
            self.trial.charging.charge(lambda: None, silent)
            self.count["recharges"] += 1
            self.trial.roaming.charged()
        except RobotError as error:
            self.count["recharges failed"] += 1
            self.count[f"charge: {error}"[:60]] += 1
            self.trial.world.carry(-1)  # staff put it into its dock

    @property
    def cleared(self) -> int:
        """Return how many maps were cleared."""
        return len(self._maps) - 1

    def told(self, took: float) -> dict[str, object]:
        """Return what is printed."""
        ended = self.count["goals"] - len(self.goals)
        attempted = ended - self.count["dropped"]
        return {
            **dict(self.count), "share": round(self.count["reached"] / max(1, ended), 3),
            "of_attempted": round(self.count["reached"] / max(1, attempted), 3),
            "near_by_truth": round(sum(d < TRUE_M for d in self.apart) / max(1, len(self.apart)), 3),
            "apart_m": [round(percentile(self.apart, q), 2) for q in (0.5, 0.9)] if self.apart else [],
            "metres": round(self.trial.world.driven, 1), "cleared": self.cleared, "flat": self.flat, "lowest": round(self.lowest, 3),
            "experiences": self.trial.brain.mind.slam.map.count, "times_real": round(self.trial.now / took, 1),
            "spent_s": {name: round(s) for name, s in self.spent.items()},
            "paper": PAPER,
        }  # fmt: skip


def main() -> None:
    """Run a day; print Table 1."""
    with tempfile.TemporaryDirectory() as folder:
        began = time.process_time()
        day = Day(Path(folder))
        day.run(HOURS * 3600)
        found = day.told(time.process_time() - began)
    share, goal = float(str(found["share"])), GOAL_PRUNING if PRUNING else GOAL
    held = (
        share >= goal and day.trial.world.driven >= PAPER["metres"] * HOURS / 24 and not day.count["recharges failed"]
        and float(str(found["times_real"])) >= TIMES and not day.flat
        and (PRUNING or CLEARED[0] <= day.cleared * 24 / HOURS <= CLEARED[1])
    )  # fmt: skip
    tell("irat_day", share, "of the goals that were accepted are reached", f">= {goal}", held, found)


if __name__ == "__main__":
    main()
