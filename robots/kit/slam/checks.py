"""Refuses numbers that no robot of this kind can send, each with one sentence."""

import math

FASTEST_M_S = 5.0
FASTEST_RAD_S = 50.0
LONGEST_STEP_S = 1.0


def bounded(name: str, value: float, low: float, high: float) -> float:
    """Return the value as a float. Raises ValueError if it is no number or outside [low, high]."""
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name} must be a number, not {value!r:.40}.") from None
    if not math.isfinite(number) or not low <= number <= high:
        raise ValueError(f"{name} must lie between {low:g} and {high:g}; {number:g} does not.")
    return number


def odometry(v: float, w: float, dt: float) -> tuple[float, float, float]:
    """Return forward speed (m/s), turning speed (rad/s) and duration (s). Raises ValueError."""
    return (
        bounded("the forward speed in m/s", v, -FASTEST_M_S, FASTEST_M_S),
        bounded("the turning speed in rad/s", w, -FASTEST_RAD_S, FASTEST_RAD_S),
        bounded("the duration of a step in s", dt, 0.0, LONGEST_STEP_S),
    )
