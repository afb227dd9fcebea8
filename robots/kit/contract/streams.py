"""Byte streams of a robot, as a map or a list of objects: key packets that hold everything, and deltas on top of them.

`docs/reference/channels.md` says the format; `tests/vectors/stream_packets.json` holds packets that Python and
TypeScript read alike.
"""

import struct
from dataclasses import dataclass

HEAD = struct.Struct("<BBBBIq")
TYPE, KEY = 3, 1
LONGEST = 1 << 20  # bytes of one packet, and of all deltas after one key packet
MOST_DELTAS = 500
MOST = 8  # streams of a robot


@dataclass(frozen=True)
class Stream:
    """A byte stream: its name, and the media type of its key packets for whoever draws it."""

    name: str
    media: str = "application/octet-stream"


@dataclass(frozen=True)
class StreamPacket:
    """A packet: which stream of the spec (from 0), number, ms since 1970, whether it holds everything, bytes.

    `run` is the low byte of its owner's epoch: a delta follows packets of the same run alone.
    """

    stream: int
    number: int
    at_ms: int
    key: bool
    data: bytes
    run: int = 0

    @property
    def follows(self) -> int | None:
        """Return the number of the packet that a delta changes; None for a key packet."""
        return None if self.key else (self.number - 1) & 0xFFFFFFFF


def pack(packet: StreamPacket) -> bytes:
    """Return the packet's bytes."""
    number = packet.number & 0xFFFFFFFF
    flags = KEY if packet.key else 0
    return HEAD.pack(TYPE, flags, packet.stream, packet.run & 0xFF, number, packet.at_ms) + packet.data


def unpack(data: bytes) -> StreamPacket:
    """Return the packet. Raises ValueError for anything else."""
    if len(data) < HEAD.size or data[0] != TYPE:
        raise ValueError("not a packet of a byte stream")
    _, flags, stream, run, number, at_ms = HEAD.unpack_from(data)
    return StreamPacket(stream, number, at_ms, bool(flags & KEY), data[HEAD.size :], run)
