"""An arm from above: where its tool was, by the joints that a state tells, and its table. No Django."""

from collections.abc import Callable, Mapping, Sequence
from math import atan2, isfinite
from typing import Any

from robots.kit.contract.find import spec_of
from robots.kit.contract.floor import Floor
from robots.kit.contract.planar import PlanarArm
from robots.kit.recording.container import Message
from robots.kit.recording.paths import Place, PoseReading, is_place

Places = tuple[Place, ...]


def tool_of(driver: str) -> Callable[[Message], PoseReading | None]:
    """Return what reads a state: where it says that the tool is (x, y in m, direction from the base), and the joints.

    It returns None for a state that does not tell all joints of the arm.
    """
    names, places_of = _arm(driver)

    def read(message: Message) -> PoseReading | None:
        try:
            told = message.content().get("joints")
            named = told if isinstance(told, Mapping) else {}
            joints = tuple(float(value) for value in named.values())
            angles = [float(named[name]) for name in names]
        except (ValueError, TypeError, KeyError):
            return None
        if not all(map(isfinite, joints)):
            return None
        places = places_of(angles)
        x, y = places[-1]
        return PoseReading((x, y, atan2(y, x)), joints, places) if all(map(is_place, places)) else None

    return read


def _arm(driver: str) -> tuple[Sequence[str], Callable[[Sequence[float]], Places]]:
    """Return the names of the joints that place the tool, and what places base, links and tool by their values."""
    planar = spec_of(driver).capability(PlanarArm)
    if planar is not None:
        return planar.joints, planar.places
    from robots.kit.arms.described import chain  # noqa: PLC0415 - not every arm has a model

    arm = chain(driver)

    def places(joints: Sequence[float]) -> Places:
        x, y = (float(v) for v in arm.forward(arm.joints_in(joints))[:2, 3])
        return (0.0, 0.0), (x, y)

    return arm.names, places


def table_of(driver: str, settings: Mapping[str, Any]) -> Floor | None:
    """Return the table, the largest of the arm's forbidden boxes, and what is forbidden on it; None without any."""
    from robots.kit.arms.boxes import forbidden_of  # noqa: PLC0415 - not every arm has a model

    forbidden = forbidden_of(driver, dict(settings))
    flat = [(box.low[0], box.low[1], box.high[0], box.high[1]) for box in forbidden]
    if not flat:
        return None
    table = max(flat, key=lambda one: (one[2] - one[0]) * (one[3] - one[1]))
    return Floor(table, tuple(one for one in flat if one != table))
