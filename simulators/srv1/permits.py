"""The permit by which the rover may drive without its owner: an area, a speed, and an end."""

from robots.kit.description import load
from robots.kit.drivers.srv1.answers import Event
from robots.kit.drivers.srv1.extension import Permit
from simulators.srv1.odometry import Odometry

FASTER, FASTER_M_S = 1.1, 0.03  # tolerance of a measured speed, which the encoders' steps make uneven
NONE = Permit(0, 0, 0.0, (0.0, 0.0, 0.0, 0.0))


class Permits:
    """The present permit, if there is one; `now` is the uptime in ms. Not for several threads."""

    def __init__(self) -> None:
        self._longest = float(load("srv1")["line"]["longest_permit_s"]) * 1000
        self.permit = NONE

    def takes(self, permit: Permit, now: int) -> bool:
        """Return whether the rover takes a permit that lasts so long."""
        return permit.until_ms - now <= self._longest

    def grant(self, permit: Permit, now: int) -> None:
        """Replace the present permit; one whose end is past ends it."""
        self.permit = permit if permit.until_ms > now else NONE

    def end(self) -> None:
        """End the permit."""
        self.permit = NONE

    @property
    def runs(self) -> bool:
        """Return whether there is a permit."""
        return self.permit is not NONE

    def left_ms(self, now: int) -> int:
        """Return how long it still lasts (ms)."""
        return max(0, self.permit.until_ms - now) if self.runs else 0

    def violation(self, place: Odometry, now: int) -> Event | None:
        """Return what violates the present permit: the time, the place or the speed; None if nothing does."""
        x0, y0, x1, y1 = self.permit.area
        if not self.runs:
            return None
        if now >= self.permit.until_ms:
            return Event.EXPIRED
        if not (x0 <= place.x <= x1 and y0 <= place.y <= y1):
            return Event.LEFT
        return Event.FAST if abs(place.linear) > self.permit.speed * FASTER + FASTER_M_S else None
