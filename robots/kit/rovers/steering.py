"""Local navigation: the six states of section 3.4, from three ranges and a waypoint to a velocity.

It remembers where walls were a moment ago and where the robot stalled (the local map), as seen from the robot now.
Pure: its memory is an argument and a result. Angles in rad, left positive; speeds in m/s and rad/s.
"""

import math
from dataclasses import dataclass, replace

from robots.kit.rovers.steering_state import Limits, Memory, Sensed, Steer, plausible

__all__ = ["Limits", "Memory", "Sensed", "Steer", "steer"]


@dataclass(frozen=True)
class _View:
    """The ranges (that of a dead sensor counts as far), how many of the three work, and the bearing to steer for.

    freer: 1 if there is more room on the left, -1 if on the right; a dead side is where a stalled robot has met a wall.
    """

    left: float
    front: float
    right: float
    alive: int
    bearing: float
    freer: int


def steer(sensed: Sensed, memory: Memory, dt: float, dice: float, limits: Limits | None = None) -> tuple[Steer, Memory]:
    """Return the velocity for the next moment and what to remember.

    `dt`: seconds since the last call, up to 1; `dice`: a random number in [0, 1) for exploration. Raises ValueError
    for a speed, bearing, dt or dice that is no finite number or out of bounds.
    """
    limits = limits or Limits()
    _check(sensed, dt, dice)
    sensed, memory = _alive(sensed, memory, dt, limits)
    sensed, memory = _freed(sensed, memory, dt, limits)
    memory = _wander(sensed, memory, dt, dice, limits)
    memory = _stalling(sensed, replace(memory, bumps=_bumped(sensed, memory, dt)), dt, limits)
    memory = replace(memory, points=_mapped(sensed, memory, dt, limits))
    seen = _view(sensed, memory, limits)
    if not seen.alive:
        return Steer("blind", 0.0, 0.0), replace(memory, v=0.0, w=0.0, side=0)
    chosen, memory = _choose(seen, memory, limits)
    most = min(limits.cruise, max(0.0, memory.v) + limits.step * dt)
    if sensed.front is None or not plausible(sensed.front):
        most = min(most, limits.slow)  # what is ahead is not known
    v = max(-limits.slow, min(chosen.v, most))
    w = max(-limits.turn, min(chosen.w, limits.turn))
    if chosen.state in ("corridor", "wall", "default"):
        allowed = _past(w, memory.points, limits)
        if allowed != w:
            v, w = max(v, min(limits.slow, most)), allowed  # past the wall first, or it would stand there for ever
    trouble = chosen.state in ("stall", "obstacle")
    troubled = memory.troubled_s + dt if trouble else max(0.0, memory.troubled_s - 2 * dt)
    return Steer(chosen.state, v, w), replace(memory, v=v, w=w, troubled_s=troubled)


def _check(sensed: Sensed, dt: float, dice: float) -> None:
    named = {"v": (sensed.v, 10.0), "w": (sensed.w, 100.0), "bearing": (sensed.bearing or 0.0, 7.0)}
    for name, (value, most) in named.items():
        if not (isinstance(value, (int, float)) and abs(value) <= most):
            raise ValueError(f"{name} must be a number of at most {most:g}, not {value!r:.30}.")
    if not (0.0 <= dt <= 1.0 and 0.0 <= dice < 1.0):
        raise ValueError(f"dt must lie in 0 to 1 s and dice in 0 to 1, not {dt!r:.30} and {dice!r:.30}.")


def _freed(sensed: Sensed, memory: Memory, dt: float, limits: Limits) -> tuple[Sensed, Memory]:
    """Explore for a while if the robot only turns left and right, as at a waypoint behind a wall."""
    idle = memory.idle_s + dt if abs(sensed.v) < 0.03 else max(0.0, memory.idle_s - 2 * dt)
    free = max(0.0, memory.free_s - dt)
    if sensed.bearing is None:
        return sensed, replace(memory, idle_s=0.0, free_s=0.0)
    if idle > limits.idle_s:
        idle, free = 0.0, limits.free_s
    return (replace(sensed, bearing=None) if free else sensed), replace(memory, idle_s=idle, free_s=free)


def _alive(sensed: Sensed, memory: Memory, dt: float, limits: Limits) -> tuple[Sensed, Memory]:
    """Treat a sensor as dead that reads "far" over a long way: in corridors there is always something near."""
    ranges, gone = (sensed.left, sensed.front, sensed.right), abs(sensed.v) * dt
    quiet = [
        far + gone if found is not None and plausible(found) and found >= 0.99 * limits.far else 0.0
        for found, far in zip(ranges, memory.quiet, strict=True)
    ]
    most = limits.quiet[0], limits.quiet[1], limits.quiet[0]
    left, front, right = (None if q > m else r for q, m, r in zip(quiet, most, ranges, strict=True))
    return replace(sensed, left=left, front=front, right=right), replace(memory, quiet=(quiet[0], quiet[1], quiet[2]))


def _wander(sensed: Sensed, memory: Memory, dt: float, dice: float, limits: Limits) -> Memory:
    """Turn the random direction of exploration with the robot; draw another when its time is over."""
    if sensed.bearing is not None:
        return replace(memory, wander_s=0.0)
    wander = math.remainder(memory.wander - sensed.w * dt, 2 * math.pi)
    left = memory.wander_s - dt
    if left <= 0.0 or abs(wander) > limits.behind:
        wander, left = (2.0 * dice - 1.0) * limits.behind * 0.9, limits.wander_s
    return replace(memory, wander=wander, wander_s=left)


def _stalling(sensed: Sensed, memory: Memory, dt: float, limits: Limits) -> Memory:
    """Count for how long the wheels have not followed their command."""
    pushes = abs(memory.v) > 0.02 and abs(sensed.v) < limits.stalled_below * abs(memory.v)
    twists = abs(memory.w) > 0.3 and abs(sensed.w) < limits.stalled_below * abs(memory.w)
    stands = (pushes and (abs(memory.w) < 0.3 or twists)) or (twists and abs(memory.v) < 0.02)
    stalled = memory.stalled_s + dt if stands else 0.0
    left = math.copysign(max(0.0, abs(memory.reversing_s) - dt), memory.reversing_s)
    if stalled < limits.stall_s:
        return replace(memory, stalled_s=stalled, reversing_s=left)
    bumps = memory.bumps
    if memory.v > 0.0:
        bumps += tuple((limits.half[0] + 0.01, y, limits.bump_s) for y in (-0.5 * limits.half[1], 0.5 * limits.half[1]))
    reversing = -limits.reverse_s if left > 0.0 else limits.reverse_s
    return replace(memory, stalled_s=0.0, reversing_s=reversing, side=0, bumps=bumps[-12:])


def _view(sensed: Sensed, memory: Memory, limits: Limits) -> _View:
    ranges = [sensed.left, sensed.front, sensed.right]
    known = [limits.far if r is None or not plausible(r) else min(r, limits.far) for r in ranges]
    bearing = memory.wander if sensed.bearing is None else math.remainder(sensed.bearing, 2 * math.pi)
    dead = plausible(sensed.left) - plausible(sensed.right)
    freer = dead or (1 if known[0] > known[2] else -1)
    return _View(known[0], known[1], known[2], sum(map(plausible, ranges)), bearing, freer)


def _choose(seen: _View, memory: Memory, limits: Limits) -> tuple[Steer, Memory]:
    """Return the first state of the six that applies."""
    if memory.reversing_s < 0.0:
        return Steer("stall", limits.slow, 0.0), memory
    if memory.reversing_s > 0.0:
        # the nose to the free side, away from the wall that must be on the other
        met = tuple((x, -seen.freer * 1.2 * limits.half[1]) for x in (0.0, 0.5 * limits.half[0], limits.half[0]))
        remembered = replace(memory, wander=0.7 * seen.freer, points=(memory.points + met)[-limits.points :])
        turning = 0.5 * seen.freer if memory.reversing_s < limits.reverse_s / 2 else 0.0
        return Steer("stall", -limits.slow, turning), remembered
    around = _obstacle(seen, memory, limits)
    if around is not None:
        return around
    behind = abs(seen.bearing) > (limits.ahead if memory.behind else limits.behind)
    if behind:
        side = memory.side or (
            1 if seen.bearing >= 0 else -1
        )  # a turn that goes on keeps its side, else two would fight
        return Steer("behind", 0.0, side * limits.turn), replace(memory, behind=True, side=side)
    memory = replace(memory, behind=False, side=0)
    pace = limits.cruise * min(1.0, max(0.3, (seen.front - limits.front_near) / 0.15))
    if seen.left < limits.wall and seen.right < limits.wall:
        return Steer("corridor", pace, limits.centre_gain * (seen.left - seen.right)), memory
    if seen.bearing > 0.0 and seen.left < limits.wall:
        return Steer("wall", pace, limits.wall_gain * (seen.left - limits.keep)), memory
    if seen.bearing < 0.0 and seen.right < limits.wall:
        return Steer("wall", pace, limits.wall_gain * (limits.keep - seen.right)), memory
    ahead = max(0.0, math.cos(seen.bearing))
    return Steer("default", pace * ahead, limits.heading_gain * seen.bearing), memory


def _obstacle(seen: _View, memory: Memory, limits: Limits) -> tuple[Steer, Memory] | None:
    """Turn away from what is near, to one side until it is clear."""
    more = limits.clear if memory.side and not memory.behind else 0.0
    if memory.behind:
        more = -limits.clear  # it turns on the spot, which needs less room
    ahead = seen.front < limits.front_near + more or _blocked(memory, limits)
    beside = min(seen.left, seen.right) < limits.side_near + more
    if not (ahead or beside):
        return None
    side = memory.side
    if not side:
        apart = seen.left - seen.right
        side = 1 if (apart > 0.0 if abs(apart) > 0.02 else seen.bearing >= 0.0) else -1
    v = -limits.slow if seen.front < limits.front_close else 0.0 if ahead else limits.slow
    return Steer("obstacle", v, side * limits.turn), replace(memory, side=side)


def _bumped(sensed: Sensed, memory: Memory, dt: float) -> tuple[tuple[float, float, float], ...]:
    """Return the places of stalls after a step."""
    cos, sin, along = math.cos(sensed.w * dt), math.sin(sensed.w * dt), sensed.v * dt
    return tuple(
        (cos * (x - along) + sin * y, cos * y - sin * (x - along), left - dt)
        for x, y, left in memory.bumps
        if left > dt and max(abs(x), abs(y)) < 1.0
    )


def _blocked(memory: Memory, limits: Limits) -> bool:
    """Tell whether a place where it stalled lies right ahead."""
    long, wide = limits.half[0] + 0.06, limits.half[1] + 0.015
    return any(0.0 < x < long and abs(y) < wide for x, y, _ in memory.bumps)


def _mapped(sensed: Sensed, memory: Memory, dt: float, limits: Limits) -> tuple[tuple[float, float], ...]:
    """Return the local map after a step: old points moved back as the robot moved, and what is seen now."""
    turned, along = sensed.w * dt, sensed.v * dt
    cos, sin = math.cos(turned), math.sin(turned)
    moved = ((cos * (x - along) + sin * y, cos * y - sin * (x - along)) for x, y in memory.points)
    points = [(x, y) for x, y in moved if abs(x) < limits.far and abs(y) < limits.far]
    for distance, side in ((sensed.left, 1), (sensed.front, 0), (sensed.right, -1)):
        if distance is not None and plausible(distance) and distance < 0.95 * limits.far:
            angle = side * limits.sensors[1]
            points.append((limits.sensors[0] + distance * math.cos(angle), distance * math.sin(angle)))
    return tuple(points[-limits.points :])


def _past(w: float, points: tuple[tuple[float, float], ...], limits: Limits) -> float:
    """Return the rate of turn, limited so that the flank meets no wall that the sensors have passed already."""
    long, wide = limits.half[0] + 0.02, limits.half[1]
    beside = [y for x, y in points if -long < x < long]
    left = min((y for y in beside if y > 0), default=1.0) - wide
    right = min((-y for y in beside if y < 0), default=1.0) - wide
    return min(w, 0.0) if w > 0 and left < limits.flank else max(w, 0.0) if w < 0 and right < limits.flank else w
