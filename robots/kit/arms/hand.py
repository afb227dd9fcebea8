"""What a gripper tells of itself: empty, or with something between its fingers. One that tells nothing is known too."""

from collections.abc import Mapping, Sequence
from typing import Any

from robots.kit.contract.session import RobotState

WIDE_M = 0.002  # fingers within this of their full opening hold nothing
STILL_M, STILL_S = 0.0005, 0.2  # fingers that move less, for so long, rest


class Hand:
    """The gripper of a description (`[gripper]` with `joint`, `open`, `empty_below`), whose state has these joints.

    `joint` is the number of the state that tells the opening (m); without it the gripper tells nothing.
    """

    def __init__(self, description: Mapping[str, Any], joints: Sequence[str]) -> None:
        gripper = description["gripper"]
        self._at = list(joints).index(gripper["joint"]) if "joint" in gripper else None
        self._wide = float(gripper["open"]) - WIDE_M if self._at is not None else 0.0
        self._narrow = float(gripper["empty_below"]) if self._at is not None else 0.0
        self._resting: tuple[float, float] | None = None  # the opening (m), and since when (s)

    @property
    def tells(self) -> bool:
        """Tell whether the hardware knows if something is between the fingers."""
        return self._at is not None

    def holds(self, state: RobotState | None) -> bool | None:
        """Return whether something is between the fingers, as far as they tell; fingers on their way seem to hold."""
        if self._at is None or state is None or len(state.joints) <= self._at:
            return None
        return self._narrow <= state.joints[self._at] < self._wide

    def is_open(self, state: RobotState) -> bool:
        """Tell whether the fingers say that they are wide open."""
        return self._at is not None and len(state.joints) > self._at and state.joints[self._at] >= self._wide

    def rests(self, state: RobotState) -> bool:
        """Take the next state; tell whether the fingers have rested for a while."""
        if self._at is None or len(state.joints) <= self._at:
            return False
        opening = state.joints[self._at]
        if self._resting is None or abs(opening - self._resting[0]) > STILL_M:
            self._resting = opening, state.at
        return state.at - self._resting[1] >= STILL_S
