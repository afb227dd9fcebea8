"""Docking by sight of the dock's two markers: the law of section 3.5, and its answer to failures.

Pure: its memory is an argument and a result. Angles in rad, speeds in m/s and rad/s, left positive.
"""

import math
from dataclasses import dataclass, replace
from statistics import median

KEPT_ANGLES = 25  # of the outer marker


@dataclass(frozen=True)
class Sighting:
    """A marker as the camera sees it.

    x: its centre in the picture, -1 at the left edge to 1 at the right; z: distance (m) from the camera; theta: angle
    (rad) at the marker between its axis and the camera, positive if the robot, facing the dock, is left of the axis.
    """

    x: float
    z: float
    theta: float


@dataclass(frozen=True)
class DockLimits:
    """Speeds, times and the two scaling terms of equation (1)."""

    gain: float = 1.0
    x_over_z: float = 20.0  # maxX/Z: x at the edge of the picture from 0.05 m
    theta: float = math.radians(30)  # maxθ
    edge: float = 0.8  # x is never wanted farther out, so that the marker stays whole in the picture
    fast: float = 0.10
    slow: float = 0.03
    turn: float = 1.0
    approach_s: float = 45.0
    final_s: float = 5.0
    unseen_s: float = 0.6
    look_s: float = 8.0
    back_s: float = 5.0
    back: float = 0.08


@dataclass(frozen=True)
class Docking:
    """phase: approach, final, reverse, look, gone (the dock is not seen), charging. tries: attempts that failed."""

    phase: str = "approach"
    phase_s: float = 0.0
    unseen_s: float = 0.0
    side: float = 1.0  # where the marker was last: 1 right, -1 left
    thetas: tuple[float, ...] = ()  # the last angles at the outer marker
    tries: int = 0


@dataclass(frozen=True)
class Velocity:
    """The command for the wheels."""

    v: float
    w: float


REST = Velocity(0.0, 0.0)


def x_desired(sighting: Sighting, limits: DockLimits) -> float:
    """Return where in the picture the outer marker should be: equation (1), with sign(0) = 0."""
    side = (sighting.theta > 0.0) - (sighting.theta < 0.0)
    normal = abs(abs(sighting.x / sighting.z / limits.x_over_z) - abs(sighting.theta / limits.theta))
    return max(-limits.edge, min(-normal * side, limits.edge))


def dock(
    outer: Sighting | None,
    small: Sighting | None,
    charging: bool,
    memory: Docking,
    dt: float,
    limits: DockLimits | None = None,
) -> tuple[Velocity, Docking]:
    """Return the velocity for the next moment and what to remember.

    `charging`: the charger says that current flows; nothing else counts as docked. Raises ValueError for a sighting
    or dt that is not finite or out of bounds.
    """
    limits = limits or DockLimits()
    _check(outer, small, dt)
    if charging:
        return REST, replace(memory, phase="charging", phase_s=0.0)
    seen = outer or small
    memory = replace(memory, phase_s=memory.phase_s + dt, unseen_s=0.0 if seen else memory.unseen_s + dt)
    if seen is not None:
        memory = replace(memory, side=math.copysign(1.0, seen.x))
    if memory.phase == "reverse":
        return _reverse(seen, memory, limits)
    if memory.phase in ("look", "gone", "charging"):
        return _look(seen, memory, limits)
    if outer is not None:
        memory = replace(memory, thetas=(*memory.thetas, outer.theta)[-KEPT_ANGLES:])
        return _approach(_steadied(outer, memory.thetas), _into("approach", memory), limits)
    if small is not None or memory.phase == "final":
        return _final(small, _into("final", memory), limits)
    if memory.unseen_s > limits.unseen_s:
        return _look(None, _into("look", replace(memory, thetas=())), limits)
    return REST, memory


def _check(outer: Sighting | None, small: Sighting | None, dt: float) -> None:
    for seen in (outer, small):
        if seen is not None and not (abs(seen.x) <= 2.0 and 0.001 <= seen.z <= 100.0 and abs(seen.theta) <= math.pi):
            raise ValueError(f"no camera sees a marker so: {seen}.")
    if not 0.0 <= dt <= 1.0:
        raise ValueError(f"dt must lie in 0 to 1 s, not {dt!r:.30}.")


def _into(phase: str, memory: Docking) -> Docking:
    return memory if memory.phase == phase else replace(memory, phase=phase, phase_s=0.0)


def _towards(wanted: float, seen: Sighting, limits: DockLimits) -> float:
    return max(-limits.turn, min(limits.gain * (wanted - seen.x), limits.turn))


def _again(memory: Docking) -> Docking:
    return replace(memory, phase="reverse", phase_s=0.0, thetas=(), tries=memory.tries + 1)


def _steadied(outer: Sighting, thetas: tuple[float, ...]) -> Sighting:
    """Return the sighting with the median of its last angles; the farther the marker, the more of them.

    The angle of a marker of a few pixels is inexact, and sometimes that of its mirror image.
    """
    return replace(outer, theta=median(thetas[-(1 + int(20 * outer.z)) :]))


def _approach(outer: Sighting, memory: Docking, limits: DockLimits) -> tuple[Velocity, Docking]:
    if memory.phase_s > limits.approach_s:
        return REST, _again(memory)
    wanted = x_desired(outer, limits)
    pace = max(limits.slow, min(0.3 * outer.z, limits.fast))
    v = pace * max(0.1, 1.0 - 2.0 * abs(wanted - outer.x))
    return Velocity(v, _towards(wanted, outer, limits)), memory


def _final(small: Sighting | None, memory: Docking, limits: DockLimits) -> tuple[Velocity, Docking]:
    if memory.phase_s > limits.final_s:
        return REST, _again(memory)
    return Velocity(limits.slow, _towards(0.0, small, limits) if small else 0.0), memory


def _reverse(seen: Sighting | None, memory: Docking, limits: DockLimits) -> tuple[Velocity, Docking]:
    if memory.phase_s > limits.back_s:
        return REST, replace(memory, phase="approach", phase_s=0.0, unseen_s=0.0)
    return Velocity(-limits.back, _towards(0.0, seen, limits) if seen else 0.0), memory


def _look(seen: Sighting | None, memory: Docking, limits: DockLimits) -> tuple[Velocity, Docking]:
    if seen is not None:
        return REST, replace(memory, phase="approach", phase_s=0.0)
    if memory.phase == "charging":  # the current has stopped: the contacts have let go
        return REST, _again(memory)
    if memory.phase == "gone" or memory.phase_s > limits.look_s:
        return REST, _into("gone", memory)
    return Velocity(0.0, -memory.side * limits.turn), memory
