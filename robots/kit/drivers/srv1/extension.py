"""Our commands behind `%`, and their answers, as frames carry them (`framing`). A stock rover is silent to them.

On the wire are whole numbers: mm, mrad, mm/s, mrad/s, mV, tenths of a degree Celsius, thousandths. Each is bounded
where it is read; a number out of its bounds is `Malformed`.
"""

from dataclasses import dataclass
from typing import ClassVar

from robots.kit.drivers.srv1.bounds import (
    CRC,
    EPOCH,
    MM,
    MM_S,
    MRAD,
    MRAD_S,
    NUMBER,
    UPTIME_MS,
    encode_numbers,
    numbers,
)
from robots.kit.drivers.srv1.framing import COMMAND, Frame
from robots.kit.drivers.srv1.protocol import Malformed

LATE_MS = 500  # a velocity or patrol that answers to an older status is refused


def _whole(value: float, unit: float) -> int:
    try:
        return round(value / unit)
    except (ValueError, OverflowError) as error:
        raise Malformed(f"{value} is no number for the rover") from error


@dataclass(frozen=True)
class Claim:
    """Command it from now on under this epoch; an older one is refused from now on. Answered by `Status`.

    It ends after a minute without a valid command under it, and when the power is lost.
    """

    letter: ClassVar[str] = "c"
    epoch: int

    def encode(self) -> Frame:
        """Return the frame. Raises Malformed, as all of these."""
        return Frame(self.letter, encode_numbers((self.epoch,), (EPOCH,)))

    @classmethod
    def decode(cls, payload: str) -> "Claim":
        """Return what a payload says. Raises Malformed, as all of these."""
        return cls(*numbers(payload, (EPOCH,)))


@dataclass(frozen=True)
class Velocity:
    """Drive with m/s ahead and rad/s to the left for at most 0.25 s. Answered by `Status`.

    `stamp`: `uptime_ms` of the status that this answers to.
    """

    letter: ClassVar[str] = "v"
    epoch: int
    linear: float
    angular: float
    stamp: int

    def encode(self) -> Frame:
        """See `Claim`; speeds are rounded to mm/s and mrad/s."""
        values = (self.epoch, _whole(self.linear, 1e-3), _whole(self.angular, 1e-3), self.stamp)
        return Frame(self.letter, encode_numbers(values, (EPOCH, MM_S, MRAD_S, UPTIME_MS)))

    @classmethod
    def decode(cls, payload: str) -> "Velocity":
        """See `Claim`."""
        epoch, linear, angular, stamp = numbers(payload, (EPOCH, MM_S, MRAD_S, UPTIME_MS))
        return cls(epoch, linear / 1000, angular / 1000, stamp)


@dataclass(frozen=True)
class Hold:
    """Brake to rest, end patrol and permit: from anybody, at any moment. Answered by `Status` when the loop is free."""

    letter: ClassVar[str] = "h"

    def encode(self) -> Frame:
        """See `Claim`."""
        return Frame(self.letter)

    @classmethod
    def decode(cls, payload: str) -> "Hold":
        """See `Claim`."""
        numbers(payload, ())
        return cls()


@dataclass(frozen=True)
class Ask:
    """Ask for the `Status`."""

    letter: ClassVar[str] = "a"

    def encode(self) -> Frame:
        """See `Claim`."""
        return Frame(self.letter)

    @classmethod
    def decode(cls, payload: str) -> "Ask":
        """See `Claim`."""
        numbers(payload, ())
        return cls()


@dataclass(frozen=True)
class Permit:
    """It may drive by itself, without its owner: until then, not faster (m/s), inside `area`. Answered by
    `Acknowledgement`.

    `until_ms` is by its own `uptime_ms`, so that a permit that comes late ends no later; one whose end is past ends
    the permit that runs. `area`: x0, y0, x1, y1 (m) in the coordinates of its odometry.
    """

    letter: ClassVar[str] = "p"
    epoch: int
    until_ms: int
    speed: float
    area: tuple[float, float, float, float]

    _bounds: ClassVar = (EPOCH, UPTIME_MS, MM_S, MM, MM, MM, MM)

    def encode(self) -> Frame:
        """See `Claim`."""
        scaled = (_whole(v, 1e-3) for v in (self.speed, *self.area))
        return Frame(self.letter, encode_numbers((self.epoch, self.until_ms, *scaled), self._bounds))

    @classmethod
    def decode(cls, payload: str) -> "Permit":
        """See `Claim`."""
        epoch, until_ms, speed, x0, y0, x1, y1 = numbers(payload, cls._bounds)
        if speed < 0 or x0 > x1 or y0 > y1:
            raise Malformed("a permit has a speed that is not negative, and an area with its lower corner first")
        return cls(epoch, until_ms, speed / 1000, (x0 / 1000, y0 / 1000, x1 / 1000, y1 / 1000))


@dataclass(frozen=True)
class Patrol:
    """Drive by the rules in force; to be said again within 0.25 s unless a permit runs. Answered by `Status`.

    The rules decide the speed, `aside` (rad, to the left of its heading) where its way leads on; after 0.25 s without
    a word it goes straight on. `stamp`: as of a `Velocity`.
    """

    letter: ClassVar[str] = "g"
    epoch: int
    stamp: int
    aside: float = 0.0

    def encode(self) -> Frame:
        """See `Claim`; an angle is rounded to mrad."""
        values = (self.epoch, self.stamp, _whole(self.aside, 1e-3))
        return Frame(self.letter, encode_numbers(values, (EPOCH, UPTIME_MS, MRAD)))

    @classmethod
    def decode(cls, payload: str) -> "Patrol":
        """See `Claim`."""
        epoch, stamp, aside = numbers(payload, (EPOCH, UPTIME_MS, MRAD))
        return cls(epoch, stamp, aside / 1000)


@dataclass(frozen=True)
class Activate:
    """Put the rule set in the flash buffer into force if its text has this CRC. Answered by `Acknowledgement`."""

    letter: ClassVar[str] = "u"
    epoch: int
    crc: int

    def encode(self) -> Frame:
        """See `Claim`."""
        return Frame(self.letter, encode_numbers((self.epoch, self.crc), (EPOCH, CRC)))

    @classmethod
    def decode(cls, payload: str) -> "Activate":
        """See `Claim`."""
        return cls(*numbers(payload, (EPOCH, CRC)))


@dataclass(frozen=True)
class Journal:
    """Ask for entries of its journal after the one with this number. Answered by `Entries`."""

    letter: ClassVar[str] = "j"
    since: int

    def encode(self) -> Frame:
        """See `Claim`."""
        return Frame(self.letter, encode_numbers((self.since,), (NUMBER,)))

    @classmethod
    def decode(cls, payload: str) -> "Journal":
        """See `Claim`."""
        return cls(*numbers(payload, (NUMBER,)))


Command = Claim | Velocity | Hold | Ask | Permit | Patrol | Activate | Journal
COMMANDS: dict[str, type[Command]] = {
    kind.letter: kind for kind in (Claim, Velocity, Hold, Ask, Permit, Patrol, Activate, Journal)
}
HOLD = Hold().encode().encode(COMMAND)  # always the same bytes, which the receive interrupt knows


def encode(command: Command) -> bytes:
    """Return the bytes of a command. Raises Malformed."""
    return command.encode().encode(COMMAND)


def decode(frame: Frame) -> Command:
    """Return the command that a frame says. Raises Malformed."""
    kind = COMMANDS.get(frame.letter)
    if kind is None:
        raise Malformed(f"there is no command with the letter {frame.letter!r}")
    return kind.decode(frame.payload)
