"""The permit by which the rover drives on when its line is lost; it is renewed on the way and ends before the grant.

Only the firmware's patrol can go on by itself. Motions that the driver leads (to a place, in place, by hand) end as
soon as it sends no velocity any more.
"""

from collections.abc import Callable
from math import cos, inf, remainder, sin, tau

from robots.kit.clock import Timer
from robots.kit.contract.session import Permit
from robots.kit.description import load
from robots.kit.drivers.srv1 import extension
from robots.kit.drivers.srv1.answers import Status
from robots.kit.drivers.srv1.line import RoverLine

MARGIN_S = 1.0  # before the end of the grant; the rover brakes in it
SHORTEST_S = 0.5  # a shorter one is not worth its bytes
LOST_S = 0.25  # without an answer for so long a message is lost
AGAIN_SHARE = 0.1  # a permit is renewed once this share of it has passed
SAME_S = 0.05  # ends that differ by less are the same
NOWHERE = (0.0, 0.0, 0.0, 0.0)
SMALLEST_M = 0.5  # of half an area's side
AHEAD_M = 0.3  # this near to the edge of its area the rover gets no permit, so that a late message stops nothing
Area = tuple[float, float, float, float]  # x0, y0, x1, y1 in m, by the rover's odometry
Pose = tuple[float, float, float]  # m, m, rad


class Alone:
    """The newest permit of one rover. `seconds`: the longest permit, 0: none. `time_left`: see `Session.time_left`."""

    def __init__(self, line: RoverLine, seconds: float, time_left: Callable[[], float], clock: Timer) -> None:
        described = load("srv1")
        self._line, self._seconds, self._time_left, self._clock = line, seconds, time_left, clock
        self._speed = float(described["motion"]["most_speed"])
        self._braking_s = float(described["line"]["rest_s"])
        self._hall = float(described["hall"]["width"]), float(described["hall"]["depth"])
        self._until = -inf  # the latest end of the permit, by this clock

    @property
    def remaining_s(self) -> float:
        """Return for how many seconds more the rover may drive without a message; 0 if it may not."""
        return max(0.0, self._until - self._clock.monotonic())

    @property
    def rests_within(self) -> float:
        """Return within how many seconds it rests without another message; 0 if it may not drive without one."""
        return max(0.0, self._until + self._braking_s - self._clock.monotonic())

    def renew(self, status: Status, pose: Pose, spread: float, permit: Permit) -> None:
        """Permit the rover to drive on by itself for as long as it may; `status` is of a moment ago.

        `pose`, `spread`: its place in the hall by that status, and how uncertain that is (m).

        Raises what `RoverLine.ask` raises.
        """
        now = self._clock.monotonic()
        seconds = min(self._seconds, self._time_left() - MARGIN_S)
        area = area_of(self._hall, status, pose, spread)
        if seconds < SHORTEST_S or area is None or not will_be_inside(area, status):
            if status.permit_ms or self._until > now:
                self._say(0, NOWHERE, permit)
                self._until = -inf  # it has answered
            return
        until = now + seconds  # the status is older, so by the rover's clock it ends sooner
        if not (-SAME_S < until - self._until < AGAIN_SHARE * self._seconds and status.permit_ms):
            self._until = max(until, self._until)  # it may have got the permit even if it does not answer
            self._say(status.uptime_ms + round(1000 * seconds), area, permit)
            self._until = until

    def note_end(self) -> None:
        """Record that the rover has answered that it rests, and has no permit."""
        self._until = -inf

    def _say(self, until_ms: int, area: Area, permit: Permit) -> None:
        self._line.ask(extension.Permit(self._line.epoch, until_ms, self._speed, area), LOST_S, permit)


def area_of(hall: tuple[float, float], status: Status, pose: Pose, spread: float) -> Area | None:
    """Return the largest area inside the hall (width, depth), in the coordinates of the odometry; None if it is small.

    The area stays away from the walls by the spread. Its sides are along the axes of the odometry, so the more these
    are turned against those of the hall, the smaller it is.
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
