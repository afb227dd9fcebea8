"""Answers of the rover to our commands behind `%`: its status, an acknowledgement, a refusal, entries of its journal.

The journal has the rover's actions and places, also from while nobody was connected.
"""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from robots.kit.drivers.srv1 import framing
from robots.kit.drivers.srv1.extension import COMMANDS, Ask, Claim, Hold, Journal, Patrol, Velocity
from robots.kit.drivers.srv1.framing import ANSWER, LONGEST_ANSWER, Bounds, Frame, encode_numbers, numbers
from robots.kit.drivers.srv1.protocol import Malformed

ENDS = ("none", "done", "silence", "held", "lost", "replaced", "permit")  # of a motion
MODES = ("rest", "hand", "patrol")
BEACON = (framing.RANGE_MM, framing.MRAD)  # range and bearing, at the end of a status where the tower is heard
REFUSED = "!"
MOST_ENTRIES = 24  # in one answer; fewer, where they are long


@dataclass(frozen=True)
class Status:
    """The status of the rover. Coordinates (m, rad) are those of its odometry, which begins at `hall.home`.

    `motion` is the newest motion's number, `end` how it ended. `temperature` is in degrees Celsius, `humidity` and
    `light` are shares. `dead_encoders` tells which encoders count nothing while their side is driven: 0 for none, 1 for
    the left, 2 for the right, 3 for both. `rules` is the CRC of the set in force, 0 for the one that the rover was made
    with. `permit_ms` is what is left of its permit, `journal` the number of its newest entry, `uptime_ms` the time
    since its start. `letter` is that of the command that this answers. `beacon`: range (m) and bearing (rad, from the
    hall's x axis to the left) of the rover from the tower; None where that is not heard, or the rover has no receiver
    for it.
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
                said[name] = bool(value) if limits is framing.FLAG else value
            else:
                said[name] = round(value * unit, 3)
        beacon = (read[-2] / 1000, read[-1] / 1000) if heard else None
        return cls(**said, letter=frame.letter, beacon=beacon)


_FIELDS: tuple[tuple[str, float | tuple[str, ...] | None, Bounds], ...] = (
    ("boot", None, framing.BOOT),
    ("epoch", None, framing.EPOCH),
    ("motion", None, framing.NUMBER),
    ("moving", None, framing.FLAG),
    ("holding", None, framing.FLAG),
    ("end", ENDS, Bounds(0, len(ENDS) - 1)),
    ("mode", MODES, Bounds(0, len(MODES) - 1)),
    ("x", 1e-3, framing.MM),
    ("y", 1e-3, framing.MM),
    ("heading", 1e-3, framing.MRAD),
    ("linear", 1e-3, framing.MM_S),
    ("angular", 1e-3, framing.MRAD_S),
    ("infrared", 1e-3, framing.RANGE_MM),
    ("sonar", 1e-3, framing.RANGE_MM),
    ("volts", 1e-3, framing.MV),
    ("temperature", 0.1, framing.DECIDEGREES),
    ("humidity", 1e-3, framing.THOUSANDTHS),
    ("light", 1e-3, framing.THOUSANDTHS),
    ("presence", None, framing.FLAG),
    ("dead_encoders", None, framing.SIDES),
    ("rules", None, framing.CRC),
    ("permit_ms", None, framing.PERMIT_MS),
    ("journal", None, framing.NUMBER),
    ("uptime_ms", None, framing.UPTIME_MS),
)


@dataclass(frozen=True)
class Acknowledgement:
    """A command was done: its letter, the newest motion's number, and the time since the start (ms)."""

    letter: str
    motion: int
    uptime_ms: int

    def encode(self) -> Frame:
        """Return the frame. Raises Malformed."""
        return Frame(self.letter, encode_numbers((self.motion, self.uptime_ms), (framing.NUMBER, framing.UPTIME_MS)))


class Reason(StrEnum):
    """Why a command was refused."""

    EPOCH = "epoch"  # another epoch commands the rover
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


class Event(StrEnum):
    """The kind of a journal entry; `value` is the number of the motion unless the kind says otherwise."""

    POWER = "power"  # value: the boot
    MOTION = "motion"
    REST = "rest"  # value: the index in `ENDS`
    CLAIM = "claim"  # value: the epoch, its lowest 31 bits
    PATROL = "patrol"
    REFLEX = "reflex"  # infrared sees something nearer than `infrared.stop`
    PERMIT = "permit"  # it begins, or is taken back; value: its ms
    EXPIRED = "expired"  # the permit's time is over
    LEFT = "left"  # the permit's area
    FAST = "fast"  # faster than the permit's speed
    RULES = "rules"  # value: the CRC
    ALONE = "alone"  # it has patrolled for a second without a message
    WAY = "way"  # its place while it drives on so
    HEARD = "heard"  # it is commanded to patrol again
    ENCODER = "encoder"  # one counts nothing while its side is driven: the permit ends


EVENTS = tuple(Event)


@dataclass(frozen=True)
class Entry:
    """One line of the journal; x and y (m) are where it was by its odometry."""

    number: int
    uptime_ms: int
    event: Event
    value: int
    x: float = 0.0
    y: float = 0.0


_ENTRY = (framing.NUMBER, framing.UPTIME_MS, Bounds(0, len(EVENTS) - 1), framing.NUMBER, framing.MM, framing.MM)


@dataclass(frozen=True)
class Entries:
    """Entries of the journal, oldest first, as many as an answer has room for; the rover forgets the oldest."""

    entries: tuple[Entry, ...]

    def encode(self) -> Frame:
        """Return the frame. Raises Malformed."""
        return Frame(Journal.letter, ";".join(_written(entry) for entry in self.entries))

    @classmethod
    def decode(cls, payload: str) -> "Entries":
        """Return what a payload says. Raises Malformed."""
        parts = payload.split(";", MOST_ENTRIES) if payload else []
        if len(parts) > MOST_ENTRIES:
            raise Malformed("there are too many entries in an answer")
        read = (numbers(part, _ENTRY) for part in parts)
        return cls(tuple(Entry(n, at, EVENTS[event], value, x / 1000, y / 1000) for n, at, event, value, x, y in read))


def _written(entry: Entry) -> str:
    where = (min(max(round(1000 * at), framing.MM.low), framing.MM.high) for at in (entry.x, entry.y))
    return encode_numbers((entry.number, entry.uptime_ms, EVENTS.index(entry.event), entry.value, *where), _ENTRY)


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
    return Acknowledgement(frame.letter, *numbers(frame.payload, (framing.NUMBER, framing.UPTIME_MS)))
