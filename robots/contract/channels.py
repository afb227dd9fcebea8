"""Values that a robot tells beside its joints: declared in its spec, told in `RobotState.values`, packed in few bytes.

`tests/vectors/state_packets.json` holds packets that Python and TypeScript read alike.
"""

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite, nan

MOST = 255


@dataclass(frozen=True)
class Scalar:
    """One number, as a battery's charge or a temperature: name, unit and the range that is usual."""

    name: str
    unit: str
    low: float
    high: float


def encode_values(channels: tuple[Scalar, ...], values: Mapping[str, float]) -> bytes:
    """Return the number of channels in a byte and a float32 for each, in their order; NaN where nothing is known.

    Raises:
        ValueError: more channels than a byte counts.

    """
    if len(channels) > MOST:
        raise ValueError(f"a robot has at most {MOST} channels")
    told = [_float32(values.get(channel.name)) for channel in channels]
    return struct.pack(f"<B{len(told)}f", len(told), *told)


def _float32(value: float | None) -> float:
    """Return the value, or NaN where there is none or none that four bytes hold."""
    if value is None or not isfinite(value) or abs(value) > 3.4e38:
        return nan
    return float(value)


def finite(values: Mapping[str, float]) -> dict[str, float]:
    """Return the values that are numbers, for a row of the database."""
    return {name: float(value) for name, value in values.items() if isfinite(value)}
