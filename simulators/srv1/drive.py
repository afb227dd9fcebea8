"""The hall rover's motor board: per cent or velocities in, rim speeds out. It forgets velocities, never per cent."""

from robots.kit.description import load
from simulators.common.motor_board import End, MotorBoard, Note

__all__ = ["Drive", "End", "Note"]
STILL_PER_CENT = 4  # up to so much power the motors do not overcome their friction


class Drive(MotorBoard):
    """See `MotorBoard`."""

    def __init__(self, note: Note) -> None:
        description = load("srv1")
        self._half = float(description["body"]["track"]) / 2
        super().__init__(description["motion"], float(description["motion"]["speed"]), note)

    def percent(self, left: int, right: int) -> None:
        """Drive both sides with so many per cent, -100 to 100, until told otherwise. Ignored during a hold.

        Raises:
            ValueError: outside these bounds.

        """
        if not (abs(left) <= 100 and abs(right) <= 100):
            raise ValueError(f"no power of the motors: {left} %, {right} %")
        rims = [0.0 if abs(p) <= STILL_PER_CENT else self._fastest * p / 100 for p in (left, right)]
        ahead, turn = (rims[0] + rims[1]) / 2, (rims[1] - rims[0]) / (2 * self._half)
        self._want((rims[0], rims[1]), (round(ahead, 6), round(turn, 6)), 0, None)

    def velocity(self, linear: float, angular: float, epoch: int, now: float) -> None:
        """Drive with these (m/s, rad/s) until the next velocity, at most for 0.25 s. Ignored during a hold.

        Both rims keep the proportion of their speeds where one would be faster than it can be.

        Raises:
            ValueError: outside their bounds, or no numbers.

        """
        if not (abs(linear) <= self._motion["speed"] and abs(angular) <= self._motion["turn"]):
            raise ValueError(f"no velocity of this robot: {linear} m/s, {angular} rad/s")
        left, right = linear - angular * self._half, linear + angular * self._half
        share = min(1.0, self._fastest / max(abs(left), abs(right), 1e-9))
        self._want((left * share, right * share), (linear, angular), epoch, now)

    def limit_ahead(self, most: float) -> None:
        """Brake to `most` ahead (m/s), with the same turn, until the velocity is forgotten or another comes."""
        left, right = self._wanted
        over = (left + right) / 2 - most
        if over > 0.0:
            self._wanted, self._brakes = (left - over, right - over), True
