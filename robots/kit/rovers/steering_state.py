"""Inputs, memory and output of local navigation. Angles in rad, left positive; speeds in m/s and rad/s."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """Speeds and distances of one robot. The defaults are the iRat's: ranges are measured from 5 cm behind its nose."""

    cruise: float = 0.15
    slow: float = 0.05
    turn: float = 1.5
    step: float = 1.5  # m/s by which the forward speed may grow in a second; it may always fall
    front_near: float = 0.12  # an obstacle
    front_close: float = 0.075  # no room to turn: back off
    side_near: float = 0.09
    clear: float = 0.03  # by which it must be farther again
    wall: float = 0.29  # a wall is there
    keep: float = 0.19  # the range to a followed wall, 45 degrees off: 0.13 m beside the robot
    far: float = 0.40
    centre_gain: float = 6.0
    wall_gain: float = 7.0
    heading_gain: float = 2.0
    behind: float = math.radians(100)  # a goal farther aside is behind
    ahead: float = math.radians(50)  # up to this angle it is no longer behind
    stalled_below: float = 0.2  # share of the commanded speed
    stall_s: float = 0.5
    reverse_s: float = 1.2
    wander_s: float = 12.0
    idle_s: float = 8.0  # without progress for so long, the goal's direction is given up
    free_s: float = 6.0  # and for so long the robot explores
    sensors: tuple[float, float] = (0.035, math.radians(45))  # m ahead of the axle, and the angle of the outer two
    half: tuple[float, float] = (0.085, 0.05)  # half the length and the width of the robot
    flank: float = 0.03  # room beside the body without which it does not turn to that side
    points: int = 60  # of the local map
    bump_s: float = 25.0
    # a sensor that has seen nothing for so many metres (the outer two, the one ahead) counts as dead
    quiet: tuple[float, float] = (2.5, 8.0)


@dataclass(frozen=True)
class Sensed:
    """Ranges (m), None or no plausible number from a dead sensor; measured speeds; the waypoint's bearing.

    Without a bearing the robot explores.
    """

    left: float | None
    front: float | None
    right: float | None
    v: float
    w: float
    bearing: float | None


@dataclass(frozen=True)
class Memory:
    """The decisions before. `troubled_s`: for how long there were only stalls and obstacles."""

    v: float = 0.0
    w: float = 0.0
    stalled_s: float = 0.0
    reversing_s: float = 0.0  # still to reverse; below zero: to go ahead, because the tail was stuck
    side: int = 0  # of a turn that goes on: 1 left, -1 right
    behind: bool = False
    wander: float = 0.0
    wander_s: float = 0.0
    troubled_s: float = 0.0
    idle_s: float = 0.0
    free_s: float = 0.0  # still to explore, because the way to the goal led nowhere
    # where it stalled, in the same frame, and how many seconds more this is an obstacle: it may be too low to see
    bumps: tuple[tuple[float, float, float], ...] = ()
    quiet: tuple[float, float, float] = (0.0, 0.0, 0.0)  # m since the left, front, right sensor has seen anything
    points: tuple[tuple[float, float], ...] = ()  # the local map: where walls were, x ahead and y left of the axle (m)


@dataclass(frozen=True)
class Steer:
    """A velocity and the state it comes from: stall, obstacle, behind, corridor, wall, default, or blind."""

    state: str
    v: float
    w: float


def plausible(distance: float | None) -> bool:
    """Tell whether a sensor has measured anything."""
    return distance is not None and bool(0.0 < distance < 100.0)
