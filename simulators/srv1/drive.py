"""The hall rover's motor board: per cent or velocities in, rim speeds out. It forgets velocities, never per cent."""

from robots.kit.description import load
from simulators.common.journal import Note
from simulators.common.rovers.motor_board import MotorBoard

STILL_PER_CENT = 4  # up to so much power the motors do not overcome their friction


class Drive(MotorBoard):
    """See `MotorBoard`."""

    def __init__(self, note: Note) -> None:
        description = load("srv1")
        super().__init__(description, float(description["motion"]["speed"]), note)

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

    def limit_ahead(self, most: float) -> None:
        """Brake to `most` ahead (m/s), with the same turn, until the velocity is forgotten or another comes."""
        left, right = self._wanted
        over = (left + right) / 2 - most
        if over > 0.0:
            self._wanted, self._brakes = (left - over, right - over), True
