"""The floor that a robot's package draws. No Django."""

from collections.abc import Mapping
from typing import Any

from robots.kit.contract.capabilities import FloorPlan
from robots.kit.contract.errors import RobotError
from robots.kit.contract.find import function, spec_of
from robots.kit.contract.floor import Floor


def floor_of(driver: str, settings: Mapping[str, Any]) -> Floor | None:
    """Return the floor that a robot's package draws; None where it draws none, or is gone."""
    try:
        offered = spec_of(driver).capability(FloorPlan)
        found = function(offered.function)(settings) if offered is not None else None
    except (LookupError, RobotError, ArithmeticError, TypeError, ValueError, AttributeError):
        return None  # a movie without a floor is one all the same
    return found if isinstance(found, Floor) else None
