"""Our commands behind `%`, as frames carry them (`framing`); `answers` are those of the rover.

On the wire are whole numbers: mm, mrad, mm/s, mrad/s, mV, tenths of a degree Celsius, thousandths. Each is bounded
where it is read; a number out of its bounds is `Malformed`. A rover with its maker's firmware does not answer.
"""

from dataclasses import astuple, dataclass
from typing import Any, ClassVar, Self

from robots.kit.drivers.srv1.framing import (
    COMMAND,
    CRC,
    EPOCH,
    MM,
    MM_S,
    MRAD,
    MRAD_S,
    NUMBER,
    UPTIME_MS,
    Bounds,
    Frame,
    encode_numbers,
    numbers,
)
from robots.kit.drivers.srv1.protocol import Malformed

LATE_MS = 500  # a velocity or patrol that answers to an older status is refused


def _whole(value: float) -> int:
    try:
        return round(value / 1e-3)
    except (ValueError, OverflowError) as error:
        raise Malformed(f"{value} is no number for the rover") from error


@dataclass(frozen=True)
class _Numbers:
    """A command of numbers; `limits` are those of its fields, in their order."""

    letter: ClassVar[str]
    limits: ClassVar[tuple[Bounds, ...]] = ()

    def values(self) -> tuple[Any, ...]:
        """Return the numbers in our units."""
        return astuple(self)

    def encode(self) -> Frame:
        """Return the frame; lengths, angles and speeds are rounded to thousandths. Raises Malformed."""
        pairs = zip(self.values(), self.limits, strict=True)
        return Frame(self.letter, encode_numbers([_whole(v) if b.milli else v for v, b in pairs], self.limits))

    @classmethod
    def decode(cls, payload: str) -> Self:
        """Return the command that a payload tells. Raises Malformed."""
        pairs = zip(numbers(payload, cls.limits), cls.limits, strict=True)
        return cls(*(value / 1000 if b.milli else value for value, b in pairs))


@dataclass(frozen=True)
class Claim(_Numbers):
    """Command the rover from now on under this epoch; an older one is refused from now on. Answered by `Status`.

    It ends after a minute without a valid command under it, and when the power is lost.
    """

    letter = "c"
    limits = (EPOCH,)
    epoch: int


@dataclass(frozen=True)
class Velocity(_Numbers):
    """Drive with m/s ahead and rad/s to the left for at most 0.25 s. Answered by `Status`.

    `stamp`: `uptime_ms` of the status that this answers to.
    """

    letter = "v"
    limits = (EPOCH, MM_S, MRAD_S, UPTIME_MS)
    epoch: int
    linear: float
    angular: float
    stamp: int


@dataclass(frozen=True)
class Hold(_Numbers):
    """Brake to rest, end patrol and permit: from anybody, at any moment. Answered by `Status` when the loop is free."""

    letter = "h"


@dataclass(frozen=True)
class Ask(_Numbers):
    """Ask for the `Status`."""

    letter = "a"


@dataclass(frozen=True)
class Permit(_Numbers):
    """Permit the rover to drive by itself, without its owner: until then, not faster (m/s), inside `area`.

    Answered by `Acknowledgement`. `until_ms` is by the rover's own `uptime_ms`, so that a permit that comes late ends
    no later; a permit whose end is past ends the one that runs. `area`: x0, y0, x1, y1 (m) in the coordinates of its
    odometry.
    """

    letter = "p"
    limits = (EPOCH, UPTIME_MS, MM_S, MM, MM, MM, MM)
    epoch: int
    until_ms: int
    speed: float
    area: tuple[float, float, float, float]

    def values(self) -> tuple[Any, ...]:
        """Return the numbers in our units."""
        return self.epoch, self.until_ms, self.speed, *self.area

    @classmethod
    def decode(cls, payload: str) -> Self:
        """Return the command that a payload tells. Raises Malformed."""
        epoch, until_ms, speed, x0, y0, x1, y1 = numbers(payload, cls.limits)
        if speed < 0 or x0 > x1 or y0 > y1:
            raise Malformed("a permit has a speed that is not negative, and an area with its lower corner first")
        return cls(epoch, until_ms, speed / 1000, (x0 / 1000, y0 / 1000, x1 / 1000, y1 / 1000))


@dataclass(frozen=True)
class Patrol(_Numbers):
    """Drive by the rules in force; to be repeated within 0.25 s unless a permit runs. Answered by `Status`.

    The rules decide the speed, `aside` (rad, to the left of its heading) the direction in which its way leads on; after
    0.25 s without a repetition the rover goes straight on. `stamp`: as of a `Velocity`.
    """

    letter = "g"
    limits = (EPOCH, UPTIME_MS, MRAD)
    epoch: int
    stamp: int
    aside: float = 0.0


@dataclass(frozen=True)
class Activate(_Numbers):
    """Put the rule set in the flash buffer into force if its text has this CRC. Answered by `Acknowledgement`."""

    letter = "u"
    limits = (EPOCH, CRC)
    epoch: int
    crc: int


@dataclass(frozen=True)
class Journal(_Numbers):
    """Ask for entries of the rover's journal after the one with this number. Answered by `Entries`."""

    letter = "j"
    limits = (NUMBER,)
    since: int


Command = Claim | Velocity | Hold | Ask | Permit | Patrol | Activate | Journal
COMMANDS: dict[str, type[Command]] = {
    kind.letter: kind for kind in (Claim, Velocity, Hold, Ask, Permit, Patrol, Activate, Journal)
}
HOLD = Hold().encode().encode(COMMAND)  # always the same bytes, which the rover's receive interrupt knows


def encode(command: Command) -> bytes:
    """Return the bytes of a command. Raises Malformed."""
    return command.encode().encode(COMMAND)


def decode(frame: Frame) -> Command:
    """Return the command that a frame says. Raises Malformed."""
    kind = COMMANDS.get(frame.letter)
    if kind is None:
        raise Malformed(f"there is no command with the letter {frame.letter!r}")
    return kind.decode(frame.payload)
