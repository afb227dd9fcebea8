"""Says which goals are won, from where the model has the objects; cameras correct it where they measure. Pure."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from robots.kit.arms.beliefs import Belief, How, Snapshot
from robots.kit.arms.chain import Matrix
from robots.kit.arms.goals import BUILD, LIFT, Goal, missing
from robots.kit.arms.objects import ObjectTable, pose_of

SWUNG_MS = 5000  # before it was taken, within which a swing counts: two periods of a thread of 1.7 m


class GoalJudge:
    """Judges the goals whenever something has changed; its caller has a lock. `now_ms` is since 1970.

    What is reached already at the first look counts as reached, but not as won: nobody has just done it.
    """

    def __init__(self, table: ObjectTable, goals: Sequence[Goal], now_ms: Callable[[], int]) -> None:
        self.goals, self._table, self._now_ms = goals, table, now_ms
        self._there: dict[str, tuple[str, ...]] | None = None
        self._won_ms: dict[str, int] = {}
        self._news: list[Goal] = []
        self._seen: dict[str, deque[tuple[int, Matrix]]] = {}  # where an object was measured in the last moments
        self._swung: dict[str, float] = {}  # by how much (m) it did so right before it was taken

    def lifts(self, name: str | None) -> bool:
        """Tell whether it matters where the tool is that holds an object."""
        return any(goal.kind == LIFT and name in goal.parts for goal in self.goals)

    def look(self, now: Snapshot, tool: Matrix | None) -> bool:
        """Judge; `tool` is its pose (4 x 4) where that is known. Returns whether something has changed."""
        for name, belief in now.beliefs.items():
            self._watch(name, belief)
        before = self._there
        self._there = {goal.name: self._reached(goal, now.beliefs, tool) for goal in self.goals}
        for goal in self.goals:
            if before is not None and self._is_whole(goal, self._there) and not self._is_whole(goal, before):
                self._won_ms[goal.name] = self._now_ms()
                self._news.append(goal)
        return self._there != before

    def facts(self) -> dict[str, Any]:
        """Return what pages are told: for each goal the objects that are there, and when it was won (ms) if it was."""
        there = self._there or {}
        return {
            goal.name: {"there": there.get(goal.name, ()), "won_ms": self._won_ms.get(goal.name)} for goal in self.goals
        }

    def news(self) -> list[Goal]:
        """Return the goals won since the last call."""
        news, self._news = self._news, []
        return news

    @staticmethod
    def _is_whole(goal: Goal, there: Mapping[str, tuple[str, ...]]) -> bool:
        return len(there[goal.name]) == len(goal.parts)

    def _reached(self, goal: Goal, beliefs: Mapping[str, Belief], tool: Matrix | None) -> tuple[str, ...]:
        return tuple(name for name in goal.parts if self._is_there(goal, name, beliefs[name], tool))

    def _is_there(self, goal: Goal, name: str, belief: Belief, tool: Matrix | None) -> bool:
        placed = belief.placed
        if placed is None:
            return False
        if goal.kind == BUILD:
            if placed.held:
                return False
            metres, angle = missing(self._table.objects[name], pose_of(placed), goal.parts[name])
            return metres <= goal.within[0] and angle <= goal.within[1]
        if not placed.held:
            return False
        if goal.kind == LIFT:
            return tool is not None and float((tool @ pose_of(placed))[2, 3]) >= goal.parts[name][2, 3]
        return self._swung.get(name, 0.0) >= goal.far

    def _watch(self, name: str, belief: Belief) -> None:
        """Remember where an object was measured, and how far it has swung when it is taken."""
        placed, seen = belief.placed, self._seen.setdefault(name, deque(maxlen=64))
        if placed is None:
            seen.clear()
        elif placed.held:
            if name not in self._swung:
                places = [at for ms, at in seen if belief.at_ms - ms <= SWUNG_MS]
                if places and self._table.objects[name].hangs:
                    places.append(np.array(self._table.objects[name].first.place))
                self._swung[name] = max((float(np.linalg.norm(a - b)) for a in places for b in places), default=0.0)
        else:
            self._swung.pop(name, None)
            if belief.how is How.MEASURED and (not seen or belief.at_ms > seen[-1][0]):
                seen.append((belief.at_ms, np.array(placed.place)))
