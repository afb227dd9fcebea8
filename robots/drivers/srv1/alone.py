"""The permit by which the rover drives on where its line is lost: renewed on the way, it ends before the grant does.

Only the firmware's patrol can go on by itself. What the driver leads (to a place, in place, by hand) rests as soon as
the rover is not told to move any more.
"""

from collections.abc import Callable
from math import cos, inf, sin

from robots.clock import Timer
from robots.contract.session import Permit
from robots.description import load
from robots.drivers.srv1 import extension
from robots.drivers.srv1.answers import Status
from robots.drivers.srv1.line import RoverLine

MARGIN_S = 1.0  # before the end of the grant; the rover brakes in it
SHORTEST_S = 0.5  # a shorter one is not worth its bytes
LOST_S = 0.25  # without an answer for so long it is lost
AGAIN_SHARE = 0.1  # of a permit has passed when it is renewed
SAME_S = 0.05
AHEAD_M = 0.3  # before the edge of the area it has none, so that a late word stops nothing


class Alone:
    """The newest permit of one rover. `seconds` is the longest, 0: none; `time_left` as `Session.time_left`."""

    def __init__(self, line: RoverLine, seconds: float, time_left: Callable[[], float], clock: Timer) -> None:
        described = load("srv1")
        self._line, self._seconds, self._time_left, self._clock = line, seconds, time_left, clock
        self._speed = float(described["motion"]["most_speed"])
        self._braking_s = float(described["line"]["rest_s"])
        self._hall = float(described["hall"]["width"]), float(described["hall"]["depth"])
        self._until = -inf  # at the latest the permit ends then, by this clock

    @property
    def left(self) -> float:
        """Return for how many seconds more the rover may drive without a word; 0 if it may not."""
        return max(0.0, self._until - self._clock.monotonic())

    @property
    def rests_within(self) -> float:
        """Return within how many seconds it rests without another word; 0 if it may not drive without one."""
        return max(0.0, self._until + self._braking_s - self._clock.monotonic())

    def renew(self, status: Status, spread: float, permit: Permit) -> None:
        """Let the rover drive on by itself for as long as it may, as it was a moment ago; `spread`: see `Whereabouts`.

        Raises what `RoverLine.ask` raises.
        """
        now = self._clock.monotonic()
        seconds = min(self._seconds, self._time_left() - MARGIN_S)
        if seconds < SHORTEST_S or not self._is_inside(status, spread):
            if status.permit_ms or self._until > now:
                self._say(status, 0.0, spread, permit)
                self._until = -inf  # it has answered
            return
        until = now + seconds  # the status is older, so by the rover's clock it ends sooner
        if not (-SAME_S < until - self._until < AGAIN_SHARE * self._seconds and status.permit_ms):
            self._until = max(until, self._until)  # it may have heard it, if it does not answer
            self._say(status, seconds, spread, permit)
            self._until = until

    def ended(self) -> None:
        """Note that the rover has said that it rests, and has no permit."""
        self._until = -inf

    def _say(self, status: Status, seconds: float, spread: float, permit: Permit) -> None:
        width, depth = self._hall
        until_ms = status.uptime_ms + round(1000 * seconds) if seconds else 0
        area = (spread, spread, max(width - spread, spread), max(depth - spread, spread))
        self._line.ask(extension.Permit(self._line.epoch, until_ms, self._speed, area), LOST_S, permit)

    def _is_inside(self, status: Status, spread: float) -> bool:
        """Tell whether the rover is inside the area, and will be a moment later."""
        ahead = AHEAD_M if status.linear > 0 else 0.0
        width, depth = self._hall
        return all(
            spread <= at <= side - spread
            for x, y in (
                (status.x, status.y),
                (status.x + ahead * cos(status.heading), status.y + ahead * sin(status.heading)),
            )
            for at, side in ((x, width), (y, depth))
        )
