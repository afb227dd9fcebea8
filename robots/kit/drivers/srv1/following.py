"""Rules by which the rover follows a straight line, turns, and keeps its distance. Pure; m, rad, s."""

from math import atan2, cos, hypot, pi, remainder, sin, sqrt

from robots.kit.drivers.srv1.ways import Place

Pose = tuple[float, float, float]
Twist = tuple[float, float]  # m/s ahead, rad/s to the left
AHEAD_M = 0.45  # the point of the line that it steers for (pure pursuit)
REACHED_M = 0.08
TURN_FIRST_RAD = 0.6  # towards a place farther aside than this it turns before it drives
ALONG_RAD = 0.1  # up to this angle it looks along its line
TURN_RAD_S, SLOW_TURN_RAD_S, TURNED_RAD = 1.2, 0.3, 0.03
REACTION_S = 0.12  # until the next velocity
NEAR_GAIN = 1.0  # 1/s: how fast it may be for each metre that is left


def room_ahead(infrared: float, sonar: float, stop: float, close: float, left: float) -> float:
    """Return how far the rover may drive ahead (m): it stops `stop` (m) before a thing that infrared sees.

    The sonar also sees things beside the ray of infrared that would touch the hull, from `close` (m) on, and black
    glass. A thing behind the end of the line, which is `left` (m) away, does not count: a place may be near a wall.
    """
    free = infrared - stop
    if sonar < left:  # the front would touch it before the middle is at the end of the line
        free = min(free, sonar - close)
    return max(0.0, free)


def toward(pose: Pose, begin: Place, end: Place, fastest: float, room: float, braking: float) -> Twist:
    """Return the velocity along the line from `begin` to `end`.

    `fastest` bounds the speed (m/s); it is less where the rover could not stop within `room` (m) with `braking` (m/s2).
    Without any room it turns to the line, from where the way may be free.
    """
    x, y = _on_line(pose, begin, end)
    aside = _aside(pose, (x, y))
    if abs(aside) > (TURN_FIRST_RAD if room > 0.0 else ALONG_RAD):
        return 0.0, turning(aside)
    left = hypot(end[0] - pose[0], end[1] - pose[1])
    speed = min(fastest, max(0.05, NEAR_GAIN * left), fastest_before(room, braking)) * cos(aside)
    away = max(hypot(x - pose[0], y - pose[1]), 0.1)
    return speed, max(-TURN_RAD_S, min(2 * speed * sin(aside) / away, TURN_RAD_S))


def fastest_before(room: float, braking: float) -> float:
    """Return the speed from which it comes to rest within `room` (m); its reaction time is counted."""
    return braking * (sqrt(REACTION_S**2 + 2 * room / braking) - REACTION_S)


def bearing(pose: Pose, begin: Place, end: Place) -> float:
    """Return the direction of the line from `begin` to `end`, to the left of the heading (rad)."""
    return _aside(pose, _on_line(pose, begin, end))


def _aside(pose: Pose, place: Place) -> float:
    return remainder(atan2(place[1] - pose[1], place[0] - pose[0]) - pose[2], 2 * pi)


def _on_line(pose: Pose, begin: Place, end: Place) -> Place:
    """Return the point of the line that lies `AHEAD_M` before the one nearest to the rover; at most its end."""
    dx, dy = end[0] - begin[0], end[1] - begin[1]
    long = hypot(dx, dy)
    if long < 1e-6:
        return end
    along = ((pose[0] - begin[0]) * dx + (pose[1] - begin[1]) * dy) / long
    share = min(max(along, 0.0) + AHEAD_M, long) / long
    return begin[0] + share * dx, begin[1] + share * dy


def is_reached(pose: Pose, begin: Place, end: Place, passed: bool) -> bool:
    """Tell whether a line's end is reached; `passed`: coming past it is enough, as at a corner."""
    if hypot(end[0] - pose[0], end[1] - pose[1]) <= REACHED_M:
        return True
    dx, dy = end[0] - begin[0], end[1] - begin[1]
    beyond = (pose[0] - end[0]) * dx + (pose[1] - end[1]) * dy >= 0.0
    return passed and beyond and hypot(end[0] - pose[0], end[1] - pose[1]) <= 3 * REACHED_M


def turning(left: float) -> float:
    """Return the rate of turn (rad/s) where `left` is still to turn (rad, to the left)."""
    return max(-TURN_RAD_S, min(max(abs(left), SLOW_TURN_RAD_S), TURN_RAD_S) * (1 if left > 0 else -1))
