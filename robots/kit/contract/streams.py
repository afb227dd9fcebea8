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


class Chain:
    """The newest key packet of a stream and the deltas after it, each numbered one higher than the packet before."""

    def __init__(self) -> None:
        self.packets: list[bytes] = []  # another list for each key packet, so that readers notice
        self._newest = self._run = self._begun = 0

    def add(self, data: bytes) -> bool:
        """Add a packet; False for a delta that does not follow, which is left out. Raises ValueError."""
        packet = unpack(data)
        if packet.key:
            self.packets, self._run, self._begun = [data], packet.run, packet.at_ms
        elif self.packets and packet.run == self._run and packet.number == (self._newest + 1) & 0xFFFFFFFF:
            self.packets.append(data)
        else:
            return self.has(packet)
        self._newest = packet.number
        return True

    def has(self, packet: StreamPacket) -> bool:
        """Tell whether a packet is one of these, come again."""
        behind = (self._newest - packet.number) & 0xFFFFFFFF
        return packet.run == self._run and behind < len(self.packets)

    def restore(self, packets: list[bytes], heard: list[bytes]) -> None:
        """Take over a chain that was kept elsewhere, unless it is older than this one, then what was heard meanwhile.

        Raises ValueError.
        """
        kept = Chain()
        for data in packets:
            kept.add(data)
        newer = kept._begun > self._begun or (kept._begun == self._begun and len(kept.packets) > len(self.packets))
        if kept.packets and newer:
            self.packets, self._newest = kept.packets, kept._newest
            self._run, self._begun = kept._run, kept._begun
        for data in heard:
            packet = unpack(data)
            if packet.at_ms >= self._begun and not self.has(packet):
                self.add(data)
