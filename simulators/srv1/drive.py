"""The motor board: per cent or velocities in, rim speeds out. It forgets a velocity, it holds, and knows its rest.

It has no lock and no clock of its own: its owner calls it under one lock, and `now` is the simulator's time in s.
"""

from collections.abc import Callable
from enum import StrEnum

from robots.description import load

Note = Callable[..., None]
STILL_PER_CENT = 4  # up to so much power the motors do not overcome their friction
STALLED_SHARE, STALLED_RIM_M_S, STALLED_S = 0.25, 0.02, 0.3  # a rim below this share of its speed for so long


class End(StrEnum):
    """How the newest motion ended."""

    NONE = "none"
    DONE = "done"
    SILENCE = "silence"
    HELD = "held"
    LOST = "lost"
    REPLACED = "replaced"
    PERMIT = "permit"


class Drive:
    """One motion is everything from rest to rest. `note` writes to the journal."""

    def __init__(self, note: Note) -> None:
        description = load("srv1")
        self._motion, self._note = description["motion"], note
        self._half = description["body"]["track"] / 2
        self._fastest = float(self._motion["speed"])
        self.motion = 0
        self._rest()

    def _rest(self) -> None:
        self._wanted = (0.0, 0.0)  # rim speeds, left and right (m/s)
        self._said: float | None = None  # when a velocity was said; None: per cent, which stay
        self._slow_since: float | None = None
        self.target = (0.0, 0.0)
        self.moving = self.holding = self.stalled = False
        self.end = End.NONE

    @property
    def wanted(self) -> tuple[float, float]:
        """Return the speed ahead (m/s) and the rate of turn to the left (rad/s) that are wanted now."""
        left, right = self._wanted
        return (left + right) / 2, (right - left) / (2 * self._half)

    def percent(self, left: int, right: int) -> None:
        """Drive both sides with so many per cent, -100 to 100, until told otherwise. Ignored during a hold.

        Raises:
            ValueError: outside these bounds.

        """
        if not (abs(left) <= 100 and abs(right) <= 100):
            raise ValueError(f"no power of the motors: {left} %, {right} %")
        speeds = [0.0 if abs(p) <= STILL_PER_CENT else self._fastest * p / 100 for p in (left, right)]
        left_m_s, right_m_s = speeds
        ahead, turn = (left_m_s + right_m_s) / 2, (right_m_s - left_m_s) / (2 * self._half)
        self._want((left_m_s, right_m_s), (round(ahead, 6), round(turn, 6)), 0, None)

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

    def _want(self, wanted: tuple[float, float], velocity: tuple[float, float], epoch: int, said: float | None) -> None:
        if self.holding:
            return
        self._wanted, self._said = wanted, said
        if not self.moving and wanted != (0.0, 0.0):
            linear, angular = velocity
            self.moving, self.motion, self.end = True, self.motion + 1, End.NONE
            self._note("motion", motion=self.motion, epoch=epoch, linear=linear, angular=angular)
        elif self.moving:
            self.end = End.NONE

    def hold(self, why: End = End.HELD) -> None:
        """Brake to rest; nothing but rest ends the hold."""
        if self.moving:
            self._wanted, self.holding, self.end = (0.0, 0.0), True, why

    def restart(self) -> None:
        """Lose the power: what moved is lost, and nothing is wanted."""
        if self.moving:
            self._note("rest", motion=self.motion, end=str(End.LOST))
        self._rest()

    def step(self, now: float, seconds: float, rims: tuple[float, float], still: bool) -> tuple[float, float]:
        """Return the rim speeds (m/s) to follow for the next `seconds`; `rims` are measured."""
        if self.moving and not self.holding and self._said is not None and now - self._said > self._motion["forget_s"]:
            if self._wanted != (0.0, 0.0):
                self.end = End.SILENCE
            self._wanted = (0.0, 0.0)
        braking = self.holding or self.end is End.SILENCE
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
        """Find out whether a wheel that should turn does not; write a rim beyond its limit, which there must not be."""
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
