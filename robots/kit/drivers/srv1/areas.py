"""Where the rover may drive by itself: the hall, less how unsure it is of its place, by its odometry. m, rad."""

from math import cos, remainder, sin, tau

from robots.kit.drivers.srv1.answers import Status

SMALLEST_M = 0.5  # of half an area's side
AHEAD_M = 0.3  # before the edge of the area it has none, so that a late word stops nothing
Area = tuple[float, float, float, float]  # x0, y0, x1, y1
Pose = tuple[float, float, float]


def area_of(hall: tuple[float, float], status: Status, pose: Pose, spread: float) -> Area | None:
    """Return the largest area inside the hall (width, depth), in the coordinates of the odometry; None if it is small.

    It keeps the spread from the walls. The odometry's axes may be turned against the hall's, and an area has sides
    along its axes, so it is smaller the more they are turned.
    """
    wide, deep = (side / 2 - spread for side in hall)
    turn = remainder(pose[2] - status.heading, tau)
    c, s = abs(cos(turn)), abs(sin(turn))
    if min(wide, deep) < SMALLEST_M:
        return None
    share = min(wide / (c * wide + s * deep), deep / (s * wide + c * deep))
    dx, dy = hall[0] / 2 - pose[0], hall[1] / 2 - pose[1]
    x, y = status.x + dx * cos(turn) + dy * sin(turn), status.y - dx * sin(turn) + dy * cos(turn)
    return x - share * wide, y - share * deep, x + share * wide, y + share * deep


def will_be_inside(area: Area, status: Status) -> bool:
    """Tell whether the rover is inside the area, and will be a moment later if it drives on."""
    x0, y0, x1, y1 = area
    ahead = AHEAD_M if status.mode == "patrol" else 0.0
    ways = (0.0, ahead)
    return all(
        x0 <= status.x + way * cos(status.heading) <= x1 and y0 <= status.y + way * sin(status.heading) <= y1
        for way in ways
    )
