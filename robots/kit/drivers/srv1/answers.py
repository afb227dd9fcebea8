"""Answers of the rover to our commands behind `%`: its status, an acknowledgement, a refusal, its journal."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from robots.kit.drivers.srv1 import bounds
from robots.kit.drivers.srv1.bounds import Bounds, encode_numbers, numbers
from robots.kit.drivers.srv1.extension import COMMANDS, Ask, Claim, Hold, Journal, Patrol, Velocity
from robots.kit.drivers.srv1.framing import ANSWER, LONGEST_ANSWER, Frame
from robots.kit.drivers.srv1.journal import Entries
from robots.kit.drivers.srv1.protocol import Malformed

ENDS = ("none", "done", "silence", "held", "lost", "replaced", "permit")  # of a motion
MODES = ("rest", "hand", "patrol")
BEACON = (bounds.RANGE_MM, bounds.MRAD)  # range and bearing, at the end of a status where the tower is heard
REFUSED = "!"


@dataclass(frozen=True)
class Status:
    """The status of the rover. Coordinates (m, rad) are those of its odometry, which begins at `hall.home`.

    `motion` is the newest motion's number, `end` how it ended. `temperature` is in degrees Celsius, `humidity` and
    `light` are shares. `dead_encoders` is 0, 1 for the left, 2 for the right, 3 for both: those that count nothing
    while their side is driven. `rules` is the CRC of the set in force, 0 for the one that it was made with. `permit_ms`
    is what is left of its permit, `journal` the number of its newest entry, `uptime_ms` the time since its start.
    `letter` is that of the command that this answers. `beacon`: range (m) and bearing (rad, from the hall's x axis
    to the left) of the rover from the tower; None where that is not heard, or the rover has no receiver for it.
    """

    boot: int
    epoch: int
    motion: int
    moving: bool
    holding: bool
    end: str
    mode: str
    x: float
    y: float
    heading: float
    linear: float
    angular: float
    infrared: float
    sonar: float
    volts: float
    temperature: float
    humidity: float
    light: float
    presence: bool
    dead_encoders: int
    rules: int
    permit_ms: int
    journal: int
    uptime_ms: int
    letter: str = Ask.letter
    beacon: tuple[float, float] | None = None

    def encode(self) -> Frame:
        """Return the frame. Raises Malformed."""
        values = []
        for name, unit, limits in _FIELDS:
            value = getattr(self, name)
            if unit is None:
                values.append(min(max(round(value), limits.low), limits.high))
            elif isinstance(unit, tuple):
                values.append(unit.index(value))
            else:  # a sensor's spike must not silence it
                values.append(min(max(round(value / unit), limits.low), limits.high))
        all_limits = [limits for _, _, limits in _FIELDS]
        if self.beacon is not None:
            all_limits += BEACON
            values += [min(max(round(v * 1000), b.low), b.high) for v, b in zip(self.beacon, BEACON, strict=True)]
        return Frame(self.letter, encode_numbers(values, all_limits))

    @classmethod
    def decode(cls, frame: Frame) -> "Status":
        """Return what a frame says. Raises Malformed."""
        said: dict[str, Any] = {}
        heard = BEACON if frame.payload.count(",") >= len(_FIELDS) else ()
        read = numbers(frame.payload, [*(limits for _, _, limits in _FIELDS), *heard])
        for value, (name, unit, limits) in zip(read, _FIELDS, strict=False):
            if isinstance(unit, tuple):
                said[name] = unit[value]
            elif unit is None:
                said[name] = bool(value) if limits is bounds.FLAG else value
            else:
                said[name] = round(value * unit, 3)
        beacon = (read[-2] / 1000, read[-1] / 1000) if heard else None
        return cls(**said, letter=frame.letter, beacon=beacon)


_FIELDS: tuple[tuple[str, float | tuple[str, ...] | None, Bounds], ...] = (
    ("boot", None, bounds.BOOT),
    ("epoch", None, bounds.EPOCH),
    ("motion", None, bounds.NUMBER),
    ("moving", None, bounds.FLAG),
    ("holding", None, bounds.FLAG),
    ("end", ENDS, Bounds(0, len(ENDS) - 1)),
    ("mode", MODES, Bounds(0, len(MODES) - 1)),
    ("x", 1e-3, bounds.MM),
    ("y", 1e-3, bounds.MM),
    ("heading", 1e-3, bounds.MRAD),
    ("linear", 1e-3, bounds.MM_S),
    ("angular", 1e-3, bounds.MRAD_S),
    ("infrared", 1e-3, bounds.RANGE_MM),
    ("sonar", 1e-3, bounds.RANGE_MM),
    ("volts", 1e-3, bounds.MV),
    ("temperature", 0.1, bounds.DECIDEGREES),
    ("humidity", 1e-3, bounds.THOUSANDTHS),
    ("light", 1e-3, bounds.THOUSANDTHS),
    ("presence", None, bounds.FLAG),
    ("dead_encoders", None, bounds.SIDES),
    ("rules", None, bounds.CRC),
    ("permit_ms", None, bounds.PERMIT_MS),
    ("journal", None, bounds.NUMBER),
    ("uptime_ms", None, bounds.UPTIME_MS),
)


@dataclass(frozen=True)
class Acknowledgement:
    """A command was done: its letter, the newest motion's number, and the time since the start (ms)."""

    letter: str
    motion: int
    uptime_ms: int

    def encode(self) -> Frame:
        """Return the frame. Raises Malformed."""
        return Frame(self.letter, encode_numbers((self.motion, self.uptime_ms), (bounds.NUMBER, bounds.UPTIME_MS)))


class Reason(StrEnum):
    """Why a command was refused."""

    EPOCH = "epoch"  # it is not the one under which it is commanded
    HOLDING = "holding"
    LATE = "late"
    BOUNDS = "bounds"  # a number that this rover does not take
    CHECKSUM = "checksum"  # of the flash buffer's text
    RULES = "rules"  # the text is no rule set


@dataclass(frozen=True)
class Refusal:
    """A command was not done."""

    letter: str
    reason: Reason

    def encode(self) -> Frame:
        """Return the frame. Raises Malformed."""
        return Frame(self.letter, REFUSED + self.reason)


Answer = Status | Acknowledgement | Refusal | Entries
STATUSES = tuple(kind.letter for kind in (Ask, Claim, Hold, Velocity, Patrol))


def encode(answer: Answer) -> bytes:
    """Return the bytes of an answer. Raises Malformed."""
    return answer.encode().encode(ANSWER)


def decode(frame: Frame) -> Answer:
    """Return the answer that a frame says. Raises Malformed."""
    if frame.letter not in COMMANDS or len(frame.payload) > LONGEST_ANSWER:
        raise Malformed(f"there is no answer to {frame.letter!r}")
    if frame.payload.startswith(REFUSED):
        try:
            return Refusal(frame.letter, Reason(frame.payload[1:]))
        except ValueError as error:
            raise Malformed(f"{frame.payload[:40]!r} is no reason") from error
    if frame.letter in STATUSES:
        return Status.decode(frame)
    if frame.letter == Journal.letter:
        return Entries.decode(frame.payload)
    return Acknowledgement(frame.letter, *numbers(frame.payload, (bounds.NUMBER, bounds.UPTIME_MS)))
