"""An arm from above: where its tool was, by the joints that a state tells, and its table. No Django."""

from collections.abc import Callable, Mapping
from math import atan2, isfinite
from typing import Any

import numpy as np

from robots.kit.arms.boxes import forbidden_of
from robots.kit.arms.described import chain
from robots.kit.contract.floor import Floor
from robots.kit.recording.container import Message
from robots.kit.recording.paths import is_place

Pose = tuple[float, float, float]


def tool_of(driver: str) -> Callable[[Message], tuple[Pose, tuple[float, ...]] | None]:
    """Return what reads a state: where it says that the tool is (x, y in m, direction from the base), and the joints.

    It returns None for a state that does not tell all joints of the arm.
    """
    arm = chain(driver)

    def read(message: Message) -> tuple[Pose, tuple[float, ...]] | None:
        try:
            told = message.content().get("joints")
            named = told if isinstance(told, Mapping) else {}
            joints = tuple(float(value) for value in named.values())
            q = np.array([float(named[name]) for name in arm.names])
        except (ValueError, TypeError, KeyError):
            return None
        if not all(map(isfinite, joints)):
            return None
        x, y = (float(v) for v in arm.forward(q)[:2, 3])
        return ((x, y, atan2(y, x)), joints) if is_place((x, y)) else None

    return read


def table_of(driver: str, settings: Mapping[str, Any]) -> Floor | None:
    """Return the table, the largest of the arm's forbidden boxes, and what is forbidden on it; None without any."""
    forbidden = forbidden_of(driver, dict(settings))
    flat = [(box.low[0], box.low[1], box.high[0], box.high[1]) for box in forbidden]
    if not flat:
        return None
    table = max(flat, key=lambda one: (one[2] - one[0]) * (one[3] - one[1]))
    return Floor(table, tuple(one for one in flat if one != table))
