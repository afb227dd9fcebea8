"""The rover's own journal, as answers carry it: its actions and places, also while nobody was connected."""

from dataclasses import dataclass
from enum import StrEnum

from robots.kit.drivers.srv1 import bounds
from robots.kit.drivers.srv1.bounds import Bounds, encode_numbers, numbers
from robots.kit.drivers.srv1.extension import Journal
from robots.kit.drivers.srv1.framing import Frame
from robots.kit.drivers.srv1.protocol import Malformed

MOST_ENTRIES = 24  # in one answer; fewer, where they are long


class Event(StrEnum):
    """The kind of a journal entry; `value` is the number of the motion unless the kind says otherwise."""

    POWER = "power"  # value: the boot
    MOTION = "motion"
    REST = "rest"  # value: the place in `answers.ENDS`
    CLAIM = "claim"  # value: the epoch, its lowest 31 bits
    PATROL = "patrol"
    REFLEX = "reflex"  # something is nearer than `infrared.stop`
    PERMIT = "permit"  # it begins, or is taken back; value: its ms
    EXPIRED = "expired"  # the permit's time is over
    LEFT = "left"  # the permit's area
    FAST = "fast"  # faster than the permit's speed
    RULES = "rules"  # value: the CRC
    ALONE = "alone"  # it has patrolled for a second without a word
    WAY = "way"  # it has driven on so
    HEARD = "heard"  # it is told to patrol again
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


_ENTRY = (bounds.NUMBER, bounds.UPTIME_MS, Bounds(0, len(EVENTS) - 1), bounds.NUMBER, bounds.MM, bounds.MM)


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
    where = (min(max(round(1000 * at), bounds.MM.low), bounds.MM.high) for at in (entry.x, entry.y))
    return encode_numbers((entry.number, entry.uptime_ms, EVENTS.index(entry.event), entry.value, *where), _ENTRY)
