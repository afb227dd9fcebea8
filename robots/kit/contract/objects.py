"""Places of objects around a robot, for a byte stream: 12 bytes an object, and in deltas only those that have moved.

An object is one big-endian number of 96 bits: its number (7 bits); x, y, z, each in steps of a 65534th of the box
(16 bits, x all ones: the object is gone); which of the quaternion's components x, y, z, w is the largest (2 bits), then
the three others in that order, in steps of a 8190th of the square root of two from its negative half on (13 bits each;
the largest is positive). In a box of 3 m a place is told to 0.03 mm, a rotation always to 0.04 degrees.

An object that is held is told once, by its place in the tool: it rides on the tool, whose pose a reader works out from
the joints, so nothing is sent while it is carried. Its x is all ones, too; then follow a one (a zero: it is gone), its
x, y, z in the tool's frame in steps of a 4095th of 512 mm from -256 mm on (12 bits each), and its rotation as above
with 2046ths (11 bits each), and a zero: 0.12 mm and 0.2 degrees. Readers of an earlier version take it for gone.
`tests/vectors/object_packets.json` holds packets that Python and TypeScript read alike.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite, sqrt
from typing import Self

SIZE, MOST = 12, 128  # bytes of an object; objects of a stream
PLACES, GONE = 65534, 65535
TURNS = 8190
HALF = sqrt(0.5)
REACH_M = 0.256  # m from the tool's point, along each axis: where an object that is held may be
HELD_PLACES, HELD_TURNS = 4095, 2046


@dataclass(frozen=True)
class Placed:
    """An object's place (m) and rotation (a quaternion x, y, z, w of any length but zero).

    `held`: both are in the frame of the tool, which holds it; else in that of the robot's base.
    """

    place: tuple[float, float, float]
    rotation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    held: bool = False


@dataclass(frozen=True)
class Box:
    """The box in which objects lie: its lowest corner and its size (m)."""

    low: tuple[float, float, float]
    size: tuple[float, float, float]

    def __post_init__(self) -> None:
        """Check the numbers. Raises ValueError."""
        if not all(map(isfinite, (*self.low, *self.size))) or min(self.size) <= 0:
            raise ValueError("a box needs finite numbers and a size above zero")

    def encode(self, number: int, placed: Placed | None) -> bytes:
        """Return the bytes of an object (None: it is gone); outside the box it is at its edge. Raises ValueError."""
        if not 0 <= number < MOST:
            raise ValueError(f"an object's number is 0 to {MOST - 1}, not {number}")
        if placed is None:
            return (number << 89 | GONE << 73).to_bytes(SIZE, "big")
        if not all(map(isfinite, placed.place)):
            raise ValueError(f"the place of object {number} is not finite")
        largest, others = _three(number, placed.rotation)
        if placed.held:
            return _held_bits(number, placed.place, largest, others).to_bytes(SIZE, "big")
        bits = number
        for at, low, size in zip(placed.place, self.low, self.size, strict=True):
            bits = bits << 16 | round(min(max((at - low) / size, 0.0), 1.0) * PLACES)
        bits = bits << 2 | largest
        for one in others:
            bits = bits << 13 | round((one + HALF) / (2 * HALF) * TURNS)
        return bits.to_bytes(SIZE, "big")

    def decode(self, data: bytes) -> tuple[int, Placed | None]:
        """Return an object's number and where it is, None: it is gone. Raises ValueError."""
        if len(data) != SIZE:
            raise ValueError(f"an object has {SIZE} bytes, not {len(data)}")
        bits = int.from_bytes(data, "big")
        number, codes = bits >> 89, [bits >> shift & 0xFFFF for shift in (73, 57, 41)]
        if codes[0] == GONE:
            return number, _held_place(bits) if bits >> 72 & 1 else None
        turns = [bits >> shift & 0x1FFF for shift in (26, 13, 0)]
        if max(codes) > PLACES or max(turns) > TURNS:
            raise ValueError("not a place")
        x, y, z = (low + code / PLACES * size for code, low, size in zip(codes, self.low, self.size, strict=True))
        return number, Placed((x, y, z), _rotation(bits >> 39 & 3, turns, TURNS))


def _held_bits(number: int, place: tuple[float, float, float], largest: int, others: list[float]) -> int:
    bits = number << 17 | GONE << 1 | 1
    for at in place:
        bits = bits << 12 | round(min(max((at + REACH_M) / (2 * REACH_M), 0.0), 1.0) * HELD_PLACES)
    bits = bits << 2 | largest
    for one in others:
        bits = bits << 11 | round((one + HALF) / (2 * HALF) * HELD_TURNS)
    return bits << 1


def _held_place(bits: int) -> Placed:
    """Return the place in the tool of an object that is held. Raises ValueError."""
    turns = [bits >> shift & 0x7FF for shift in (23, 12, 1)]
    if max(turns) > HELD_TURNS or bits & 1:
        raise ValueError("not a place in the tool")
    x, y, z = ((bits >> shift & 0xFFF) / HELD_PLACES * 2 * REACH_M - REACH_M for shift in (60, 48, 36))
    return Placed((x, y, z), _rotation(bits >> 34 & 3, turns, HELD_TURNS), held=True)


def _rotation(largest: int, codes: list[int], steps: int) -> tuple[float, float, float, float]:
    """Return the quaternion whose components but the largest have these codes, out of so many steps."""
    rotation = [code / steps * 2 * HALF - HALF for code in codes]
    rotation.insert(largest, sqrt(max(0.0, 1.0 - sum(one * one for one in rotation))))
    return rotation[0], rotation[1], rotation[2], rotation[3]


def _three(number: int, rotation: tuple[float, float, float, float]) -> tuple[int, list[float]]:
    """Return which component is the largest, and the three others of the same rotation with that one positive."""
    largest = max(range(4), key=lambda n: abs(rotation[n]))
    if not all(map(isfinite, rotation)) or not rotation[largest]:
        raise ValueError(f"the rotation of object {number} is none")
    scaled = [one / rotation[largest] for one in rotation]  # within -1 and 1, the largest is 1
    length = sqrt(sum(one * one for one in scaled))
    return largest, [one / length for n, one in enumerate(scaled) if n != largest]


class KnownObjects:
    """The objects of a robot that its stream has told so far, for the writer and for the reader of the stream."""

    def __init__(self, box: Box) -> None:
        self._box = box
        self._told: dict[int, bytes] = {}

    def key(self, objects: Mapping[int, Placed]) -> bytes:
        """Return a key packet: all objects. Raises ValueError."""
        self._told = {number: self._box.encode(number, placed) for number, placed in sorted(objects.items())}
        return b"".join(self._told.values())

    def delta(self, objects: Mapping[int, Placed]) -> bytes:
        """Return what has changed since the packet before, b"" if nothing has. Raises ValueError."""
        new = {number: self._box.encode(number, placed) for number, placed in sorted(objects.items())}
        gone = [self._box.encode(number, None) for number in self._told.keys() - new.keys()]
        changed = [data for number, data in new.items() if self._told.get(number) != data]
        self._told = new
        return b"".join([*gone, *changed])

    def take(self, data: bytes, key: bool) -> Self:
        """Take over a packet; nothing of one that cannot be read. Raises ValueError."""
        parts = [data[at : at + SIZE] for at in range(0, len(data), SIZE)]
        read = {number: (placed, part) for part in parts for number, placed in [self._box.decode(part)]}
        self._told = {} if key else dict(self._told)
        for number, (placed, part) in read.items():
            if placed is None:
                self._told.pop(number, None)
            else:
                self._told[number] = part
        return self

    @property
    def objects(self) -> dict[int, Placed]:
        """Return where the objects are, by number."""
        known = (self._box.decode(data) for data in self._told.values())
        return {number: placed for number, placed in known if placed is not None}


Told = KnownObjects  # its name in 0.1, until 1.0
