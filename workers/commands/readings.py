"""The values of a robot's channels at the beginning and at the end of a motion, for its statistics."""

from math import isfinite
from typing import Any

from robots.kit.contract.capabilities import Statistics
from workers.robot.owned import OwnedRobot


class Readings:
    """Of one motion after another; a robot without statistics has none."""

    def __init__(self, owned: OwnedRobot) -> None:
        self._owned = owned
        declared = owned.robot.spec().capability(Statistics)
        self._names = declared.channels() if declared is not None else ()
        self.wanted = bool(self._names)
        self._began: dict[str, float] = {}

    def begin(self) -> None:
        """Read at the beginning of a motion."""
        self._began = self._read()

    def end(self) -> dict[str, Any]:
        """Return what the result of the motion holds of its beginning and of its end, by the name of the channel."""
        began, self._began = self._began, {}
        return {"channels": {"began": began, "ended": self._read()}} if self._names else {}

    def _read(self) -> dict[str, float]:
        state = self._owned.driver.latest() if self._names else None
        told = {name: state.values.get(name) for name in self._names} if state is not None else {}
        return {name: float(v) for name, v in told.items() if isinstance(v, int | float) and isfinite(v)}
