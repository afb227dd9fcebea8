"""Values that a robot tells beside its joints: declared in its spec, told in `RobotState.values`, packed in few bytes.

`tests/vectors/state_packets.json` holds packets that Python and TypeScript read alike.
"""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil, hypot, inf, isfinite, nan, remainder, tau

MOST = 255


@dataclass(frozen=True)
class Scalar:
    """One number, as a battery's charge or a temperature: name, unit and the range that is usual."""

    name: str
    unit: str
    low: float
    high: float


@dataclass(frozen=True)
class Scale:
    """The resolution of a number in compact states: whole steps from `low` to `high`, in the unit of the number.

    Raises ValueError where this is no range of 1 to 2^32 - 2 steps.
    """

    low: float
    high: float
    step: float

    def __post_init__(self) -> None:
        """Refuse a scale that cannot be packed."""
        if not (isfinite(self.low) and isfinite(self.high) and isfinite(self.step)):
            raise ValueError("A scale is finite.")
        if not (self.low < self.high and self.step > 0 and (self.high - self.low) / self.step < 2**32 - 2):
            raise ValueError(f"From {self.low:g} to {self.high:g} by {self.step:g} is no scale.")

    @property
    def steps(self) -> int:
        """Return the number of the last step."""
        return ceil((self.high - self.low) / self.step - 1e-9)

    @property
    def bits(self) -> int:
        """Return the bits of a number; all ones stand for one that is not known."""
        return (self.steps + 1).bit_length()

    def code(self, number: float) -> int | None:
        """Return the nearest step, all ones for a number that is not known; None for one outside the scale."""
        if not isfinite(number):
            return int((1 << self.bits) - 1)
        if not self.low - self.step / 2 <= number <= self.high + self.step / 2:
            return None
        return min(self.steps, max(0, round((number - self.low) / self.step)))

    def number(self, code: int) -> float:
        """Return the number of a step; NaN for all ones. Raises ValueError for a step that is too high."""
        if code == (1 << self.bits) - 1:
            return nan
        if code > self.steps:
            raise ValueError("a step outside its scale")
        return self.low + code * self.step


@dataclass(frozen=True)
class Pose:
    """The coordinates of `RobotState.pose`, the place of the robot's tool or body, in this order.

    `x`, `y` and `z` are in m, all others in rad. `packed`: state packets carry it too; where a console can work it
    out from the joints they need not.
    """

    coordinates: tuple[str, ...]
    packed: bool = True

    def scalars(self) -> tuple[Scalar, ...]:
        """Return its coordinates with their units, each without a range of its own."""
        return tuple(Scalar(name, "m" if name in LENGTHS else "rad", -inf, inf) for name in self.coordinates)

    def apart(self, one: Sequence[float], other: Sequence[float]) -> tuple[float, float]:
        """Return how far two places lie apart (m), and the greatest difference of an angle (rad, at most half a turn).

        Raises ValueError where one of them has another number of coordinates.
        """
        by = [(n, b - a) for n, a, b in zip(self.coordinates, one, other, strict=True)]
        turned = (abs(remainder(difference, tau)) for name, difference in by if name not in LENGTHS)
        return hypot(*(difference for name, difference in by if name in LENGTHS)), max(turned, default=0.0)


LENGTHS = ("x", "y", "z")
IN_PLANE = Pose(("x", "y", "heading"))
IN_SPACE = Pose(("x", "y", "z", "roll", "pitch", "yaw"))


def encode_values(
    channels: tuple[Scalar, ...], values: Mapping[str, float], more: tuple[float, ...] = ()
) -> bytes:  # fmt: skip
    """Return how many numbers follow, in a byte, and float32s: each channel in their order, then `more`.

    NaN where nothing is known.

    Raises:
        ValueError: more numbers than a byte counts.

    """
    if len(channels) + len(more) > MOST:
        raise ValueError(f"a robot has at most {MOST} channels")
    told = [*(float32(values.get(channel.name)) for channel in channels), *map(float32, more)]
    return struct.pack(f"<B{len(told)}f", len(told), *told)


def float32(value: float | None) -> float:
    """Return the value, or NaN if there is none or it does not fit four bytes."""
    if value is None or not isfinite(value) or abs(value) > 3.4e38:
        return nan
    return float(value)


def finite(values: Mapping[str, float]) -> dict[str, float]:
    """Return the values that are numbers, for a row of the database."""
    return {name: float(value) for name, value in values.items() if isfinite(value)}


def whole(values: tuple[float, ...]) -> list[float]:
    """Return the numbers for a row of the database; none at all where one of them is no number."""
    return [float(value) for value in values] if all(map(isfinite, values)) else []
