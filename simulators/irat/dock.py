"""The geometry of the dock: a board with markers, guides that lead the robot in, a stop, two springs as contacts.

In the dock's frame: the origin on the floor below the markers, x out of the dock, in m.
"""

from math import cos, hypot, sin

STOP_M, STOP_HIGH_M = 0.020, 0.020  # where the robot's nose rests
GUIDE_HIGH_M = 0.020  # not above the lower edge of the outer marker: higher guides would hide it from the side
GUIDES = (
    ((0.0, 0.055), (0.105, 0.059), (0.255, 0.135), (0.0, 0.135)),
    ((0.0, -0.135), (0.255, -0.135), (0.105, -0.059), (0.0, -0.055)),
)  # convex, anticlockwise: a throat, then a funnel
DOCKED_M = 0.105  # the robot's axle when its nose is at the stop
DISCS = ((0.03, 0.02), (0.03, -0.02))  # on the robot's underside, in its frame
SPRINGS = ((0.075, 0.02), (0.075, -0.02))  # under the discs of a robot that stands at the stop
DISC_M = 0.009  # radius


def touching(dock: tuple[float, float, float], robot: tuple[float, float, float]) -> tuple[bool, bool]:
    """Return for each spring whether a disc lies on it; poses in m, m, rad.

    The robot faces the dock, so its left disc belongs to the dock's right spring. The charger needs that polarity:
    another disc on a spring does not count.
    """
    x, y, heading = dock
    found = []
    for (sx, sy), (dx, dy) in zip(SPRINGS, DISCS[::-1], strict=True):
        spring = x + cos(heading) * sx - sin(heading) * sy, y + sin(heading) * sx + cos(heading) * sy
        disc = robot[0] + cos(robot[2]) * dx - sin(robot[2]) * dy, robot[1] + sin(robot[2]) * dx + cos(robot[2]) * dy
        found.append(hypot(spring[0] - disc[0], spring[1] - disc[1]) <= DISC_M)
    return found[0], found[1]
