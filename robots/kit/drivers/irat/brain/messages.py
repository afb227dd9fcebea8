"""Messages between the owner and the brain's process: msgpack with a length before it, over two pipes.

Positions on the map in m, angles in rad, left positive; times in s.
"""

import struct
from typing import IO

import msgspec

from robots.kit.drivers.irat.packets import Why
from robots.kit.rovers.docking import Sighting

HEAD = struct.Struct("<I")
MOST_BYTES = 8 << 20
NONE = -1  # no experience


class Feed(msgspec.Struct, frozen=True, tag=True, array_like=True):
    """A step of odometry, perhaps with the picture at its end.

    find: search the picture for the dock's markers. docked: the robot stands in its dock, where it learns nothing new.
    """

    at: float
    v: float
    w: float
    dt: float
    jpeg: bytes | None = None
    find: bool = False
    docked: bool = False


class Aim(msgspec.Struct, frozen=True, tag=True, array_like=True):
    """Lead to a place of map `map_number`: to the experience, or without one to the experience nearest to x, y."""

    number: int
    map_number: int
    x: float
    y: float
    experience: int = NONE


class AimAtDock(msgspec.Struct, frozen=True, tag=True, array_like=True):
    """Lead to the most promising place from where the dock was seen and that was not tried yet."""

    number: int
    tried: tuple[int, ...] = ()


class Forget(msgspec.Struct, frozen=True, tag=True, array_like=True):
    """End the guidance; `place`: an experience from where the dock was looked for and not seen."""

    place: int = NONE


class Clear(msgspec.Struct, frozen=True, tag=True, array_like=True):
    """Begin a new map."""

    number: int
    why: Why = Why.STAFF


class Care(msgspec.Struct, frozen=True, tag=True, array_like=True):
    """Keep the map small for days by pruning; without it the map is cleared now and then."""

    number: int
    pruning: bool


class Save(msgspec.Struct, frozen=True, tag=True, array_like=True):
    """Write the map now."""

    number: int


class Key(msgspec.Struct, frozen=True, tag=True, array_like=True):
    """Make the next packet of a stream one that holds everything."""

    stream: str


class Guided(msgspec.Struct, frozen=True, tag=True, array_like=True):
    """The next waypoint on the way to `goal`: its bearing and distance; whether the goal is reached."""

    goal: int
    reached: bool
    bearing: float
    distance: float


class Seen(msgspec.Struct, frozen=True, tag=True, array_like=True):
    """The answer to a `Feed`, with its `at`.

    picture: its verdict (see `robots.kit.slam.slam.Step`). outer, small: the dock's markers.
    age: of the map, in s outside the dock.
    """

    at: float
    map_number: int
    pose: tuple[float, float, float]
    experience: int
    experiences: int
    docks: int
    picture: str
    pruning: bool
    age: float
    guided: Guided | None = None
    outer: Sighting | None = None
    small: Sighting | None = None


class Answer(msgspec.Struct, frozen=True, tag=True, array_like=True):
    """The answer to a numbered message: why it is refused, or an empty text; the goal, and its time limit (s)."""

    number: int
    refusal: str = ""
    cleared: bool = False  # it is refused because its map is gone
    experience: int = NONE
    limit_s: float = 0.0


class Packet(msgspec.Struct, frozen=True, tag=True, array_like=True):
    """The next packet of a byte stream."""

    stream: str
    data: bytes
    key: bool


ToBrain = Feed | Aim | AimAtDock | Forget | Clear | Care | Save | Key
FromBrain = Seen | Answer | Packet
_encode = msgspec.msgpack.Encoder().encode
to_brain = msgspec.msgpack.Decoder(ToBrain)
from_brain = msgspec.msgpack.Decoder(FromBrain)


def frame(message: ToBrain | FromBrain) -> bytes:
    """Return a message's bytes with their length before them."""
    data = _encode(message)
    return HEAD.pack(len(data)) + data


def read(pipe: IO[bytes]) -> bytes | None:
    """Return the next message's bytes, None at the end of the pipe."""
    head = pipe.read(HEAD.size)
    if len(head) < HEAD.size:
        return None
    (size,) = HEAD.unpack(head)
    if size > MOST_BYTES:
        return None
    data = pipe.read(size)
    return data if len(data) == size else None
