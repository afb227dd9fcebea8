"""The rover's own driving: at the speed of its rules, in the direction that commands lead, away from near things.

Below all rules is the reflex: it halts before what infrared sees nearer than `infrared.stop`, or the sonar nearer than
`sonar.close`, turns in place until the way is clear, and goes on.
"""

from math import copysign, sin
from typing import Protocol

from robots.kit.description import load

TURN_RAD_S = 0.8
SLOWEST_M_S = 0.02  # a lower speed of the rules means that the way is closed
TURN_FIRST_RAD, LEAD_M = 0.6, 0.45  # for a greater angle it turns in place first; the point ahead that it steers for
ROLLING_M_S = 0.04  # it halts before it turns
CLEAR_SHARE, CLEAR_SONAR_M = 2.5, 0.6  # distances of a clear way: times `infrared.stop`, and m


class Rules(Protocol):
    """A rule set; `simulators.srv1.rules.RuleSet` evaluates one of fuzzy rules."""

    @property
    def inputs(self) -> tuple[str, str]:
        """Return the names of the two readings: infrared, sonar, volts, temperature, humidity, light, presence."""

    def speed_mm_s(self, first: int, second: int, /) -> int:
        """Return the speed ahead (mm/s) for two readings, in thousandths of m, V, degrees Celsius and per cent."""


class Patrol:
    """Computes velocities from distances. Not for several threads."""

    def __init__(self) -> None:
        described = load("srv1")
        self._stop, self._close = float(described["infrared"]["stop"]), float(described["sonar"]["close"])
        self._turns = False
        self.reflexes = 0

    def begin(self) -> None:
        """Begin anew, ahead."""
        self._turns = False

    def velocity(
        self, infrared: float, sonar: float, rolling: float, speed: float, aside: float = 0.0
    ) -> tuple[float, float]:
        """Return the velocity: ahead (m/s), and to the left (rad/s).

        `infrared` and `sonar` are distances (m), `rolling` is the present speed, `speed` that of the rules (m/s),
        `aside` the angle to the left of its heading at which the way leads on (rad).
        """
        if abs(aside) > TURN_FIRST_RAD:
            return 0.0, 0.0 if abs(rolling) > ROLLING_M_S else copysign(TURN_RAD_S, aside)
        near = infrared < self._stop or sonar < self._close
        if near and not self._turns:
            self.reflexes += 1
        if near or speed < SLOWEST_M_S:
            self._turns = True
        elif infrared > CLEAR_SHARE * self._stop and sonar > CLEAR_SONAR_M:
            self._turns = False
        if not self._turns:
            return speed, 2 * speed * sin(aside) / LEAD_M
        return 0.0, 0.0 if abs(rolling) > ROLLING_M_S else TURN_RAD_S
