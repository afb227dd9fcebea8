"""The iRat's motor board: velocities in, rim speeds out. It forgets a velocity, it holds, and it knows its rest."""

from robots.kit.description import load
from simulators.common.motor_board import End, MotorBoard, Note

__all__ = ["Drive", "End", "Note"]


class Drive(MotorBoard):
    """See `MotorBoard`."""

    def __init__(self, note: Note) -> None:
        description = load("irat")
        motion = description["motion"]
        self._half = description["body"]["track"] / 2
        super().__init__(motion, motion["speed"] + motion["turn"] * self._half, note)

    def velocity(self, linear: float, angular: float, epoch: int, now: float) -> None:
        """Drive with these (m/s, rad/s) until the next velocity, at most for 0.25 s.

        Raises:
            ValueError: outside their bounds, or no numbers.

        """
        if not (abs(linear) <= self._motion["speed"] and abs(angular) <= self._motion["turn"]):
            raise ValueError(f"no velocity of this robot: {linear} m/s, {angular} rad/s")
        rims = linear - angular * self._half, linear + angular * self._half
        self._want(rims, (linear, angular), epoch, now)
