"""The motor board of a robot with a left and a right side: it turns commands into rim speeds.

It has no lock and no clock of its own: its owner calls it under one lock, and `now` is the simulator's time in s.
"""

from collections.abc import Mapping
from enum import StrEnum
from typing import Any

from simulators.common.journal import Note

STALLED_SHARE, STALLED_RIM_M_S, STALLED_S = 0.25, 0.02, 0.3  # a rim below this share of its speed for so long


class End(StrEnum):
    """The end of the newest motion."""

    NONE = "none"
    DONE = "done"
    SILENCE = "silence"
    HELD = "held"
    LOST = "lost"
    REPLACED = "replaced"
    PERMIT = "permit"


class MotorBoard:
    """One motion is everything from rest to rest. `note` writes to the journal.

    `description` is the robot's, `fastest` the greatest speed of a rim (m/s).
    """

    def __init__(self, description: Mapping[str, Any], fastest: float, note: Note) -> None:
        self._motion, self._half = description["motion"], float(description["body"]["track"]) / 2
        self._fastest, self._note = fastest, note
        self.motion = 0
        self._rest()

    def _rest(self) -> None:
        self._wanted = (0.0, 0.0)  # rim speeds, left and right (m/s)
        self._said: float | None = None  # when they were commanded; None: they stay until others are
        self._slow_since: float | None = None
        self.target = (0.0, 0.0)
        self.moving = self.holding = self.stalled = self._brakes = False
        self.end = End.NONE

    def _want(self, rims: tuple[float, float], velocity: tuple[float, float], epoch: int, said: float | None) -> None:
        """Change to these rim speeds (m/s), except during a hold; the journal gets `velocity` (m/s, rad/s)."""
        if self.holding:
            return
        self._wanted, self._said, self._brakes = rims, said, False
        if not self.moving and rims != (0.0, 0.0):
            linear, angular = velocity
            self.moving, self.motion, self.end = True, self.motion + 1, End.NONE
            self._note("motion", motion=self.motion, epoch=epoch, linear=linear, angular=angular)
        elif self.moving:
            self.end = End.NONE

    def velocity(self, linear: float, angular: float, epoch: int, now: float) -> None:
        """Drive with these (m/s, rad/s) until the next velocity, at most for 0.25 s. Ignored during a hold.

        Where one rim would be faster than it can be, both get slower, in the same proportion.

        Raises:
            ValueError: outside their bounds, or no numbers.

        """
        if not (abs(linear) <= self._motion["speed"] and abs(angular) <= self._motion["turn"]):
            raise ValueError(f"no velocity of this robot: {linear} m/s, {angular} rad/s")
        left, right = linear - angular * self._half, linear + angular * self._half
        share = min(1.0, self._fastest / max(abs(left), abs(right), 1e-9))
        self._want((left * share, right * share), (linear, angular), epoch, now)

    def hold(self, why: End = End.HELD) -> None:
        """Brake to rest; nothing but rest ends the hold."""
        if self.moving:
            self._wanted, self.holding, self.end = (0.0, 0.0), True, why

    def restart(self) -> None:
        """Lose the power: the motion ends, and no velocity is in force."""
        if self.moving:
            self._note("rest", motion=self.motion, end=str(End.LOST))
        self._rest()

    def step(self, now: float, seconds: float, rims: tuple[float, float], still: bool) -> tuple[float, float]:
        """Return the rim speeds (m/s) to follow for the next `seconds`; `rims` are measured."""
        if self.moving and not self.holding and self._said is not None and now - self._said > self._motion["forget_s"]:
            if self._wanted != (0.0, 0.0):
                self.end = End.SILENCE
            self._wanted = (0.0, 0.0)
        braking = self.holding or self._brakes or self.end is End.SILENCE
        most = self._motion["braking" if braking else "acceleration"] * seconds
        left, right = (at + min(max(to - at, -most), most) for at, to in zip(self.target, self._wanted, strict=True))
        self.target = left, right
        self._watch(now, rims)
        if self.moving and self.target == self._wanted == (0.0, 0.0) and still:
            self.moving = self.holding = False
            self.end = End.DONE if self.end is End.NONE else self.end
            self._note("rest", motion=self.motion, end=str(self.end))
        return self.target

    def _watch(self, now: float, rims: tuple[float, float]) -> None:
        """Detect a wheel that should turn and does not; record a rim speed beyond its limit, which must not happen."""
        if not max(abs(to) for to in self.target) <= self._fastest + 1e-6:  # also if it is NaN
            self._note("passed", target=list(self.target))
        slow = any(
            abs(to) > STALLED_RIM_M_S and abs(rim) < STALLED_SHARE * abs(to)
            for to, rim in zip(self.target, rims, strict=True)
        )
        if not slow:
            self._slow_since, self.stalled = None, False
        elif self._slow_since is None:
            self._slow_since = now
        elif now - self._slow_since > STALLED_S and not self.stalled:
            self.stalled = True
            self._note("stalled", motion=self.motion)
