"""Conversions of the rover's analogue counts; the electronics are ours, as the paper names only the sensors.

Counts are 0 to 1023. Infrared is a triangulation sensor, whose voltage falls with the distance; the others are linear.
"""

from enum import IntEnum
from typing import Any

FULL = 1023
COLDEST, WARMEST = -20.0, 80.0  # degrees Celsius at 0 and at FULL


class Channel(IntEnum):
    """The channels to which the sensors are connected."""

    INFRARED = 1
    TEMPERATURE = 2
    HUMIDITY = 3
    LIGHT = 4
    PRESENCE = 5


def _whole(count: float) -> int:
    return min(FULL, max(0, round(count)))


def infrared_counts(metres: float, near: float) -> int:
    """Return what the converter gives for a distance (m) to a sensor that sees from `near` (m) on."""
    return _whole(FULL * near / max(metres, near))


def infrared_m(counts: int, infrared: dict[str, Any]) -> float:
    """Return the distance (m), between `near` and `far` of the description's table `infrared`."""
    return float(min(max(infrared["near"] * FULL / max(1, counts), infrared["near"]), infrared["far"]))


def temperature_counts(celsius: float) -> int:
    """Return what the converter gives for a temperature (degrees Celsius)."""
    return _whole(FULL * (celsius - COLDEST) / (WARMEST - COLDEST))


def temperature_c(counts: int) -> float:
    """Return the temperature (degrees Celsius)."""
    return COLDEST + (WARMEST - COLDEST) * counts / FULL


def share_counts(share: float) -> int:
    """Return what the converter gives for a share 0 to 1: of humidity, of light."""
    return _whole(FULL * share)


def share(counts: int) -> float:
    """Return the share, 0 to 1: of humidity, of light."""
    return counts / FULL


def is_present(counts: int) -> bool:
    """Return whether the sensor of presence sees somebody."""
    return counts > FULL // 2
