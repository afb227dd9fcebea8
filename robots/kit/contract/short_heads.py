"""Deltas of byte streams with a head of 3 bytes instead of 16, on a socket over a thin line.

A socket delivers in order, so what a delta follows is known there: the packet of its stream that came last over the
same socket. A short delta is u8 16 plus the stream, u16 (little-endian) the low 4 bits of its number above the 12 of
the ms after the packet before, then its bytes. Key packets, and deltas of another packet or later than 12 bits hold,
keep the whole head. `docs/reference/channels.md` says it; `tests/vectors/short_heads.json` holds packets
that Python and TypeScript read alike.
"""

import struct
from dataclasses import replace

from robots.kit.contract.streams import HEAD, MOST, StreamPacket, pack, unpack

SHORT = struct.Struct("<BH")
FIRST = 16  # the first byte, of stream 0
NUMBERS, LATER_MS = 1 << 4, 1 << 12


def is_short(data: bytes) -> bool:
    """Return whether a message of a socket is a delta with a short head."""
    return bool(data) and FIRST <= data[0] < FIRST + MOST


class ShortHeads:
    """The newest packet of each stream that went over one socket, for its writer or for its reader."""

    def __init__(self) -> None:
        self._newest: dict[int, StreamPacket] = {}  # without its bytes

    def shorten(self, data: bytes) -> bytes:
        """Return a packet as it is written next over the socket. Raises ValueError for anything else."""
        packet = unpack(data)
        before = self._newest.get(packet.stream)
        self._note(packet)
        if packet.stream >= MOST or before is None or not _follows(packet, before):
            return data
        later_ms = packet.at_ms - before.at_ms
        if not 0 <= later_ms < LATER_MS:
            return data
        both = packet.number % NUMBERS * LATER_MS + later_ms
        return SHORT.pack(FIRST + packet.stream, both) + data[HEAD.size :]

    def restore(self, data: bytes) -> bytes | None:
        """Return the whole packet that was read next from the socket; None if what it follows did not come.

        Raises ValueError for what is neither a packet nor a short delta.
        """
        if not is_short(data):
            self._note(unpack(data))
            return data
        if len(data) < SHORT.size:
            raise ValueError(f"a delta with a short head has at least {SHORT.size} bytes")
        first, both = SHORT.unpack_from(data)
        stream, (low, later_ms) = first - FIRST, divmod(both, LATER_MS)
        before = self._newest.get(stream)
        if before is None or (before.number + 1) % NUMBERS != low:
            self._newest.pop(stream, None)
            return None
        number = (before.number + 1) & 0xFFFFFFFF
        packet = StreamPacket(stream, number, before.at_ms + later_ms, False, data[SHORT.size :], before.run)
        self._note(packet)
        return pack(packet)

    def _note(self, packet: StreamPacket) -> None:
        self._newest[packet.stream] = replace(packet, data=b"")


def _follows(packet: StreamPacket, before: StreamPacket) -> bool:
    return packet.follows == before.number and packet.run == before.run
