"""Values of a description's tables, which people write: each is read with a clear sentence about what is wrong."""

from collections.abc import Mapping, Sequence
from math import isfinite, radians
from typing import Any

from robots.kit.arms.chain import Matrix
from robots.kit.arms.pose import Six, matrix

Three = tuple[float, float, float]


class BadDescription(ValueError):
    """A table of the description is not valid; the message names what it is of and what is wrong."""


def pose(who: str, table: Mapping[str, Any], place: str, angles: str) -> Matrix:
    """Return the pose (4 x 4) of a place (m) and, if the table has them, its angles (degrees)."""
    x, y, z = three(who, table, place)
    a, b, c = (radians(v) for v in (three(who, table, angles) if angles in table else (0.0, 0.0, 0.0)))
    six: Six = x, y, z, a, b, c
    return matrix(six)


def table_of(description: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Return a table of a description."""
    found = description.get(name)
    if not isinstance(found, Mapping):
        raise BadDescription(f"the table [{name}] is needed")
    return found


def three(who: str, table: Mapping[str, Any], name: str) -> Three:
    """Return three numbers."""
    x, y, z = numbers(who, table, name, 3)
    return x, y, z


def numbers(who: str, table: Mapping[str, Any], name: str, count: int) -> list[float]:
    """Return so many numbers."""
    value = table.get(name)
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != count:
        raise BadDescription(f"{who}: {name} needs {count} numbers")
    return [real(who, name, one) for one in value]


def number(who: str, table: Mapping[str, Any], name: str, otherwise: float | None = None) -> float:
    """Return a number, `otherwise` where the table has none."""
    value = table.get(name, otherwise)
    return real(who, name, value)


def real(who: str, name: str, value: Any) -> float:
    """Return a value that has to be a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise BadDescription(f"{who}: {name} needs finite numbers")
    return float(value)


def whole(who: str, table: Mapping[str, Any], name: str, low: int, high: int, otherwise: int | None = None) -> int:
    """Return a whole number from `low` to `high`, `otherwise` where the table has none."""
    value = table.get(name, otherwise)
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise BadDescription(f"{who}: {name} is a whole number from {low} to {high}")
    return value
