"""Ranges of numbers in words, as pages and answers give them."""

from math import isfinite

NOTHING = 5e-7  # a measured number below this is rounding of a calculation: half a micrometre, or microradian


def plain(number: float) -> str:
    """Return a bound without an exponent where one may be written out: up to 12 digits."""
    return f"{number:.12g}"


def readable(number: float) -> str:
    """Return a measured or given number as people read it: whole ones as they are, others to four digits."""
    if isinstance(number, int) or not isfinite(number) or number == round(number, 9) == int(number):
        return plain(number)
    if abs(number) < NOTHING:
        return "0"
    return f"{number:.0f}" if abs(number) >= 1000 else f"{number:.4g}"


def from_to(low: float, high: float, unit: str = "") -> str:
    """Return an inclusive range with its unit, as "0.5 to 3 m"."""
    numbers = f"{plain(low)} to {plain(high)}"
    return f"{numbers} {unit}".rstrip()
