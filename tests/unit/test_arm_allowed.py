"""Where the measured arm may be: the quick look says what a whole look at each step says."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.drivers.pa10.courses import Courses
from simulators.common.arm.position_guard import OFF_M, OFF_RAD, PositionGuard

PLANNER = Courses().planner
LIMITS, ZONES = PLANNER.limits, PLANNER.zones
FREE = np.radians([0.0, 25.0, 75.0, 0.0, 80.0, 0.0])
AXES = len(LIMITS.low)
anywhere = st.tuples(*[st.floats(float(a) - 0.1, float(b) + 0.1) for a, b in zip(LIMITS.low, LIMITS.high, strict=True)])
walks = st.lists(st.tuples(*[st.floats(-0.2, 0.2)] * AXES), max_size=12)
ways = st.lists(st.floats(-0.06, 0.06), max_size=12)


class Whole:
    """Looks at every box and range at each step."""

    def __init__(self, q):
        self._floor, self._most = ZONES.floor(ZONES.distances(q)), self._outside(q) + OFF_RAD

    @staticmethod
    def _outside(q):
        return np.maximum(0.0, np.maximum(LIMITS.low - q, q - LIMITS.high))

    def violation(self, q):
        distances = ZONES.distances(q)
        touch = ZONES.entered(distances + OFF_M, self._floor)
        if touch is not None:
            return str(touch)
        if (self._outside(q) > self._most).any():
            return PLANNER.chain.broken_limit(q)
        self._floor = ZONES.raised(self._floor, distances)
        self._most = np.minimum(self._most, self._outside(q) + OFF_RAD)
        return ""


def agree(q, walk):
    quick, whole = PositionGuard(PLANNER, q), Whole(q)
    for step in walk:
        q = q + step
        said = whole.violation(q)
        assert quick.violation(q) == said
        if said:
            quick.accept(PLANNER, q)
            whole = Whole(q)


@given(anywhere, walks)
def test_a_quick_look_says_what_a_whole_look_says(begin, walk):
    agree(np.array(begin), [np.array(step) for step in walk])


@given(st.integers(0, AXES - 1), st.booleans(), st.floats(-0.1, 0.1), ways)
def test_so_it_does_at_the_end_of_a_joints_range(axis, high, inside, way):
    q, along = FREE.copy(), np.eye(AXES)[axis]
    q[axis] = LIMITS.high[axis] - inside if high else LIMITS.low[axis] + inside
    agree(q, [step * along for step in way])
