"""Paths of a robot that rolls: cleaned, made small enough for a page, placed on the floor. Pure; m, rad. No Django."""

from collections.abc import Iterable, Sequence
from math import cos, dist, isfinite, sin
from typing import NamedTuple

from robots.kit.contract import channels
from robots.kit.contract.floor import FARTHEST, Box, Floor

Place = tuple[float, float]
Line = list[Place]
Pose = tuple[float, float, float]
Start = tuple[float, ...]  # what a preview begins from: joints (rad, m) of an arm, else the pose
IN_PLANE = channels.IN_PLANE.coordinates  # the pose of a robot whose path is drawn
PREVIEWS = 10  # of the commands of a recording
POINTS = 400  # of a path on a page
LEAST_M = 0.01  # between two points of a path
JUMP_M = 1.0  # from one state to the next: it was carried, or its odometry began anew
MARGIN_M, LEAST_ROOM_M = 0.3, 2.0  # around a path without a floor; the least that is shown then


class PoseReading(NamedTuple):
    """Where a state says that a robot is: its pose, or that of an arm's tool; what a preview begins from.

    `arm`: the places of an arm from its base to its tool (m), between which its links are drawn.
    """

    pose: Pose
    start: Start
    arm: tuple[Place, ...] = ()


def is_place(pose: Sequence[float]) -> bool:
    """Tell whether a pose begins with a place that can be drawn."""
    return len(pose) >= 2 and all(isfinite(v) and abs(v) < FARTHEST for v in pose)


def lines(poses: Iterable[Sequence[float]]) -> list[Line]:
    """Return the path through poses, in pieces where it jumps; poses without a place are left out."""
    found: list[Line] = []
    for pose in poses:
        if not is_place(pose):
            continue
        place = float(pose[0]), float(pose[1])
        away = dist(found[-1][-1], place) if found else JUMP_M
        if away >= JUMP_M:
            found.append([place])
        elif away >= LEAST_M:
            found[-1].append(place)
    return found


def simplified(path: Sequence[Line], most: int = POINTS) -> list[Line]:
    """Return the path with at most so many points: the ends of its pieces, and points that are far enough apart."""
    kept = [line for line in path if line][: most // 2]
    apart = LEAST_M
    while sum(map(len, kept)) > most:
        apart *= 1.5
        kept = [_thinned(line, apart) for line in kept]
    return [[(round(x, 3), round(y, 3)) for x, y in line] for line in kept]


def _thinned(line: Line, apart: float) -> Line:
    found = [line[0]]
    for place in line[1:-1]:
        if dist(found[-1], place) >= apart:
            found.append(place)
    return found if len(line) == 1 else [*found, line[-1]]


def placed(poses: Iterable[Sequence[float]], start: Sequence[float]) -> Line:
    """Return poses of a robot's own frame, x ahead, y to its left, on the floor, where it was at `start`."""
    x0, y0, heading = start[:3]
    c, s = cos(heading), sin(heading)
    found = ((x0 + c * pose[0] - s * pose[1], y0 + s * pose[0] + c * pose[1]) for pose in poses)
    return [place for place in found if is_place(place)]


def plot_bounds(floor: Floor | None, path: Iterable[Line]) -> Box:
    """Return what a plot shows (x0, y0, x1, y1): the floor's room and all of the path.

    Without a floor it is at least 2 m each way.
    """
    places = [place for line in path for place in line]
    margin = MARGIN_M if floor is None else 0.0
    xs = [x + side for x, _ in places for side in (-margin, margin)]
    ys = [y + side for _, y in places for side in (-margin, margin)]
    if floor is not None:
        xs += [floor.room[0], floor.room[2]]
        ys += [floor.room[1], floor.room[3]]
    least = LEAST_ROOM_M if floor is None else 0.0
    (x0, x1), (y0, y1) = _widened(xs, least), _widened(ys, least)
    return x0, y0, x1, y1


def _widened(values: Sequence[float], least: float) -> tuple[float, float]:
    low, high = min(values, default=0.0), max(values, default=0.0)
    more = max(0.0, least - (high - low)) / 2
    return low - more, high + more
