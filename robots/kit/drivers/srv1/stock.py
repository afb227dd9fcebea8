"""A rover with its maker's firmware, which is silent to `%`: driven by hand alone, in bursts that end by themselves.

It has no hold that is read during a motion, no epoch and no odometry. So each burst lasts at most 0.1 s and needs a
permit; the rover never drives by itself, and never tells its place. Only the counts of its wheels tell whether it
moves. So it counts as moving from before a burst, and from before it is connected, until it was commanded to stop and
the counts were read.
"""

import contextlib
from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from robots.kit.clock import TIMER, Limit, Timer
from robots.kit.contract.errors import BadRequest, HardwareFault
from robots.kit.contract.session import Permit, RobotState
from robots.kit.description import load
from robots.kit.drivers.permits import until_held
from robots.kit.drivers.srv1 import protocol, sensors
from robots.kit.drivers.srv1.line import RoverLine
from robots.kit.drivers.srv1.sensors import Channel
from robots.kit.drivers.srv1.spec import Mode

BURST_S = 0.1
READINGS = 2  # without a count until its wheels rest: they may be between two counts
REST_S = 2.0  # within which it rests after a stop, also from its greatest speed
NOT_AT_REST = "The rover did not come to rest after a stop."
BY_HAND_ONLY = "This rover has its maker's firmware: it can be driven by hand, and nothing else."
T = TypeVar("T")


class StockRover:
    """Drives one such rover. `keep` gets each new state."""

    def __init__(self, line: RoverLine, keep: Callable[[RobotState], RobotState], clock: Timer = TIMER) -> None:
        self._line, self._keep, self._clock = line, keep, clock
        self._described = load("srv1")
        self._may_run = True
        self._newest: RobotState | None = None
        self.holds = 0

    def connect(self) -> RobotState:
        """Command a stop, because another client may have left it running, and ask. Raises LineGone, LineSilent.

        `5` is enough: before the first `M` since a reset it ends nothing, but then nothing runs either.
        """
        self._runs()
        self._stop()
        return self.state()

    def _runs(self) -> None:
        """Note that it may move from now on, before it can say so."""
        self._may_run = True
        if self._newest is not None:
            self._newest = self._keep(replace(self._newest, moving=True, mode=Mode.HAND))

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
        mode = Mode.HAND if self._may_run else Mode.RESTING
        self._newest = RobotState(self._clock.monotonic(), (), (), self._may_run, True, mode=mode, values=values)
        return self._keep(self._newest)

    def _counts(self, channel: Channel) -> int:
        return self._line.letters(protocol.analogue(channel), _line(lambda line: protocol.analogue_of(line, channel)))

    def drive(self, wanted: Callable[[], tuple[float, float]], permit: Permit, began: Callable[[], None]) -> None:
        """Drive with these shares (-1 to 1) of the greatest velocities, burst by burst, until `permit` ends it."""
        free = until_held(permit, lambda: self.holds)
        try:
            while True:
                free()
                left, right = self._per_cent(*wanted())
                self._runs()
                self._line.letters(protocol.motion(left, right, BURST_S), protocol.confirms(b"M"), free)
                began()
                self.state()
        finally:
            with contextlib.suppress(HardwareFault):  # then it is still said to move
                self._rest()

    def _per_cent(self, forward: float, turn: float) -> tuple[int, int]:
        motion, body = self._described["motion"], self._described["body"]
        ahead, aside = forward * motion["most_speed"], turn * motion["turn"] / 2 * body["track"] / 2
        left, right = (100 * rim / motion["speed"] for rim in (ahead - aside, ahead + aside))
        return max(-100, min(round(left), 100)), max(-100, min(round(right), 100))

    def hold(self) -> RobotState:
        """Begin no other burst, and repeat the stop until its wheels rest. Raises HardwareFault if they do not."""
        self.holds += 1
        self._runs()
        self._rest()
        return self.state()

    def _rest(self) -> None:
        limit = Limit(self._clock, REST_S)
        while self._may_run:
            if limit.over:
                raise HardwareFault(NOT_AT_REST)
            self._stop()

    def _stop(self) -> None:
        self._line.letters(protocol.STOP, protocol.confirms(protocol.STOP))
        turns = (self._line.letters(protocol.ENCODERS, _line(protocol.encoders_of)) for _ in range(READINGS))
        self._may_run = any(left or right for left, right in turns)

    def refuse(self, kind: str) -> None:
        """Raise BadRequest for what only our part of the firmware can do."""
        if kind != "drive":
            raise BadRequest(BY_HAND_ONLY)


def _line(decode: Callable[[bytes], T]) -> Callable[[bytes], T | None]:
    """Return a function that decodes the first line of an answer; it returns None while the line is not whole."""
    return lambda data: decode(data.partition(b"\n")[0]) if b"\n" in data else None
