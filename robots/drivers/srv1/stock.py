"""A rover with its maker's firmware, which is silent to `%`: driven by hand alone, in bursts that end by themselves.

It has no hold that is read during a motion, no epoch and no odometry. So a burst lasts at most 0.1 s, each after a
permit; it never drives itself, and never says where it is.
"""

from collections.abc import Callable
from typing import TypeVar

from robots.clock import TIMER, Timer
from robots.contract.errors import BadRequest
from robots.contract.session import Permit, RobotState
from robots.description import load
from robots.drivers.permits import until_held
from robots.drivers.srv1 import protocol, sensors
from robots.drivers.srv1.line import RoverLine
from robots.drivers.srv1.modes import Mode
from robots.drivers.srv1.sensors import Channel

BURST_S = 0.1
BY_HAND_ONLY = "This rover has its maker's firmware: it can be driven by hand, and nothing else."
T = TypeVar("T")


class StockRover:
    """Drives one such rover. `keep` gets each new state."""

    def __init__(self, line: RoverLine, keep: Callable[[RobotState], RobotState], clock: Timer = TIMER) -> None:
        self._line, self._keep, self._clock = line, keep, clock
        self._described = load("srv1")
        self._bursts = False  # one may be under way
        self.holds = 0

    def state(self) -> RobotState:
        """Ask for sonar and the analogue channels. Raises LineGone, LineSilent."""
        counts = {channel: self._counts(channel) for channel in Channel}
        sonar = self._line.letters(protocol.SONAR, _line(protocol.sonar_of))
        values = {
            "infrared": sensors.infrared_m(counts[Channel.INFRARED], self._described["infrared"]),
            "sonar": sonar,
            "temperature": sensors.temperature_c(counts[Channel.TEMPERATURE]),
            "humidity": 100 * sensors.share(counts[Channel.HUMIDITY]),
            "light": 100 * sensors.share(counts[Channel.LIGHT]),
            "presence": float(sensors.is_present(counts[Channel.PRESENCE])),
        }
        mode = Mode.HAND if self._bursts else Mode.RESTING
        return self._keep(
            RobotState(self._clock.monotonic(), (), (), self._bursts, True, mode=mode, values=values)
        )  # fmt: skip

    def _counts(self, channel: Channel) -> int:
        return self._line.letters(protocol.analogue(channel), _line(lambda line: protocol.analogue_of(line, channel)))

    def drive(self, wanted: Callable[[], tuple[float, float]], permit: Permit, began: Callable[[], None]) -> None:
        """Drive with these shares (-1 to 1) of the greatest velocities, burst by burst, until `permit` ends it."""
        free = until_held(permit, lambda: self.holds)
        done = protocol.acknowledgement(b"M")
        try:
            while True:
                free()
                left, right = self._per_cent(*wanted())
                self._bursts = True
                burst = protocol.motion(left, right, BURST_S)
                self._line.letters(burst, lambda data: True if done in data else None, permit=free)
                began()
                self.state()
        finally:
            self._bursts = False

    def _per_cent(self, forward: float, turn: float) -> tuple[int, int]:
        motion, body = self._described["motion"], self._described["body"]
        ahead, aside = forward * motion["most_speed"], turn * motion["turn"] / 2 * body["track"] / 2
        left, right = (100 * rim / motion["speed"] for rim in (ahead - aside, ahead + aside))
        return max(-100, min(round(left), 100)), max(-100, min(round(right), 100))

    def hold(self) -> RobotState:
        """Begin no other burst; return once the last one has ended, and the rover has been told to stop."""
        self.holds += 1
        done = protocol.acknowledgement(protocol.STOP)
        self._line.letters(protocol.STOP, lambda data: True if done in data else None)
        self._bursts = False
        return self.state()

    def refuse(self, kind: str) -> None:
        """Raise BadRequest for what only our part of the firmware can do."""
        if kind != "drive":
            raise BadRequest(BY_HAND_ONLY)


def _line(decode: Callable[[bytes], T]) -> Callable[[bytes], T | None]:
    """Return what decodes the first line of an answer; None while it is not whole."""
    return lambda data: decode(data.partition(b"\n")[0]) if b"\n" in data else None
