"""The local map of section 3.4: where walls were a moment ago and where the robot stalled, seen from the robot now."""

import math

from robots.kit.rovers.steering_state import Limits, Memory, Sensed, plausible


def bumped(sensed: Sensed, memory: Memory, dt: float) -> tuple[tuple[float, float, float], ...]:
    """Return the places of stalls after a step."""
    cos, sin, along = math.cos(sensed.w * dt), math.sin(sensed.w * dt), sensed.v * dt
    return tuple(
        (cos * (x - along) + sin * y, cos * y - sin * (x - along), left - dt)
        for x, y, left in memory.bumps
        if left > dt and max(abs(x), abs(y)) < 1.0
    )


def blocked(memory: Memory, kept: Limits) -> bool:
    """Tell whether a place where it stalled lies right ahead."""
    long, wide = kept.half[0] + 0.06, kept.half[1] + 0.015
    return any(0.0 < x < long and abs(y) < wide for x, y, _ in memory.bumps)


def mapped(sensed: Sensed, memory: Memory, dt: float, kept: Limits) -> tuple[tuple[float, float], ...]:
    """Return the local map after a step: old points moved back as the robot moved, and what is seen now."""
    turned, along = sensed.w * dt, sensed.v * dt
    cos, sin = math.cos(turned), math.sin(turned)
    moved = ((cos * (x - along) + sin * y, cos * y - sin * (x - along)) for x, y in memory.points)
    held = [(x, y) for x, y in moved if abs(x) < kept.far and abs(y) < kept.far]
    for distance, side in ((sensed.left, 1), (sensed.front, 0), (sensed.right, -1)):
        if distance is not None and plausible(distance) and distance < 0.95 * kept.far:
            angle = side * kept.sensors[1]
            held.append((kept.sensors[0] + distance * math.cos(angle), distance * math.sin(angle)))
    return tuple(held[-kept.points :])


def past(w: float, points: tuple[tuple[float, float], ...], kept: Limits) -> float:
    """Return the turn without what would bring the flank against a wall that the sensors have passed already."""
    long, wide = kept.half[0] + 0.02, kept.half[1]
    beside = [y for x, y in points if -long < x < long]
    left = min((y for y in beside if y > 0), default=1.0) - wide
    right = min((-y for y in beside if y < 0), default=1.0) - wide
    return min(w, 0.0) if w > 0 and left < kept.flank else max(w, 0.0) if w < 0 and right < kept.flank else w
