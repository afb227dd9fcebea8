"""Bounds of the numbers in our frames, and how they are written and read: whole numbers with commas between them."""

from collections.abc import Sequence
from typing import NamedTuple

from robots.kit.drivers.srv1.protocol import Malformed

MOST_DIGITS = 17  # with a sign


class Bounds(NamedTuple):
    """The least and the greatest value of a whole number."""

    low: int
    high: int


EPOCH = Bounds(0, 2**53 - 1)
BOOT = Bounds(0, 2**32 - 1)
NUMBER = Bounds(0, 2**31)  # of motions, of entries
UPTIME_MS = Bounds(0, 2**40)
PERMIT_MS = Bounds(0, 600_000)  # what is left of it; a rover's own limit is in its description
MM = Bounds(-1_000_000, 1_000_000)
MM_S = Bounds(-2000, 2000)
MRAD = Bounds(-6284, 6284)
MRAD_S = Bounds(-10_000, 10_000)
RANGE_MM = Bounds(0, 100_000)
MV = Bounds(0, 60_000)
DECIDEGREES = Bounds(-1000, 2000)
THOUSANDTHS = Bounds(0, 1000)
FLAG = Bounds(0, 1)
SIDES = Bounds(0, 3)
CRC = Bounds(0, 0xFFFF)


def _bounded(value: int, bounds: Bounds) -> int:
    if not bounds.low <= value <= bounds.high:
        raise Malformed(f"{value} is not from {bounds.low} to {bounds.high}")
    return value


def encode_numbers(values: Sequence[int], bounds: Sequence[Bounds]) -> str:
    """Return numbers as text. Raises Malformed for one outside its bounds."""
    return ",".join(str(_bounded(value, limits)) for value, limits in zip(values, bounds, strict=True))


def numbers(payload: str, bounds: Sequence[Bounds]) -> list[int]:
    """Return exactly as many numbers as there are bounds. Raises Malformed, also for one outside its bounds."""
    parts = payload.split(",", len(bounds)) if payload else []
    if len(parts) != len(bounds):
        raise Malformed(f"{len(bounds)} numbers were expected in {payload[:40]!r}")
    return [_bounded(_number(part), limits) for part, limits in zip(parts, bounds, strict=True)]


def _number(text: str) -> int:
    digits = text.removeprefix("-")
    if not (digits.isascii() and digits.isdigit() and len(text) <= MOST_DIGITS):
        raise Malformed(f"{text[:40]!r} is no number")
    return int(text)
