"""The floor that a robot's package draws, or an arm's table. No Django."""

from collections.abc import Mapping
from typing import Any

from robots.kit.contract.capabilities import ArmModel, FloorPlan
from robots.kit.contract.errors import RobotError
from robots.kit.contract.find import function, spec_of
from robots.kit.contract.floor import Floor


def floor_of(driver: str, settings: Mapping[str, Any]) -> Floor | None:
    """Return the floor that a robot's package draws, or an arm's table; None where there is none, or it is gone."""
    try:
        spec = spec_of(driver)
        offered = spec.capability(FloorPlan)
        if offered is None and spec.capability(ArmModel) is not None:
            from robots.kit.recording.arm import table_of  # noqa: PLC0415 - not every robot is an arm

            return table_of(driver, settings)
        found = function(offered.function)(settings) if offered is not None else None
    except (LookupError, RobotError, ArithmeticError, TypeError, ValueError, AttributeError):
        return None  # a movie without a floor is one all the same
    return found if isinstance(found, Floor) else None
