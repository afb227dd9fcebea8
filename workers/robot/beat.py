"""Which compact states are sent: each of a robot that moves, one beat a second of one that rests."""

from math import inf, isfinite, nan

from robots.kit.contract.compact import Layout
from robots.kit.contract.session import RobotState

REST_S = 1.0  # between two states that say the same
STEPS = 4  # of a number's scale, by which noise may change it


class RestBeat:
    """Compares each state with the one that was sent last."""

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        self._sent: tuple[object, ...] = ()
        self._numbers: tuple[float, ...] = ()
        self._at = -inf

    def due(self, state: RobotState, stopped: bool, values: dict[str, float], now: float) -> bool:
        """Return whether a state has to be sent, which then counts as sent; `values`: as `Layout.encode` takes them."""
        said = (state.moving, stopped, state.mode, len(state.joints))
        numbers = (*state.joints, *(values.get(name, nan) for name, _ in self._layout.values))
        if not state.moving and said == self._sent and now - self._at < REST_S and self._alike(numbers):
            return False
        self._sent, self._numbers, self._at = said, numbers, now
        return True

    def _alike(self, numbers: tuple[float, ...]) -> bool:
        for scale, one, other in zip(self._layout.scales, self._numbers, numbers, strict=False):
            known = isfinite(one), isfinite(other)
            if known[0] != known[1] or (all(known) and abs(one - other) > (STEPS + 0.5) * scale.step):
                return False
        return True
