"""Deltas of byte streams with a head of 4 bytes instead of 16, on a socket over a thin line.

A socket delivers in order, so what a delta follows is known there: the packet of its stream that came last over the
same socket. A short delta is u8 9, u8 the stream (the high 3 bits) and the low 5 bits of its number, u16
(little-endian) ms after the packet before, then its bytes. Key packets, and deltas of another packet or later than a
u16 holds, keep the whole head. `docs/reference/channels.md` says it; `tests/vectors/short_heads.json` holds packets
that Python and TypeScript read alike.
"""

import struct

from robots.kit.contract.streams import HEAD, MOST, StreamPacket, pack, unpack

SHORT = struct.Struct("<BBH")
TYPE = 9
NUMBERS, LATEST_MS = 1 << 5, (1 << 16) - 1


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
        if not 0 <= later_ms <= LATEST_MS:
            return data
        return SHORT.pack(TYPE, packet.stream << 5 | packet.number % NUMBERS, later_ms) + data[HEAD.size :]

    def restore(self, data: bytes) -> bytes | None:
        """Return the whole packet that was read next from the socket; None if what it follows did not come.

        Raises ValueError for what is neither a packet nor a short delta.
        """
        if data[:1] != bytes((TYPE,)):
            self._note(unpack(data))
            return data
        if len(data) < SHORT.size:
            raise ValueError("a delta with a short head has at least 4 bytes")
        _, both, later_ms = SHORT.unpack_from(data)
        before = self._newest.get(both >> 5)
        if before is None or (before.number + 1) % NUMBERS != both % NUMBERS:
            self._newest.pop(both >> 5, None)
            return None
        number = (before.number + 1) & 0xFFFFFFFF
        packet = StreamPacket(
            before.stream, number, before.at_ms + later_ms, False, data[SHORT.size :], before.run
        )  # fmt: skip
        self._note(packet)
        return pack(packet)

    def _note(self, packet: StreamPacket) -> None:
        self._newest[packet.stream] = StreamPacket(
            packet.stream, packet.number, packet.at_ms, packet.key, b"", packet.run
        )


def _follows(packet: StreamPacket, before: StreamPacket) -> bool:
    return packet.follows == before.number and packet.run == before.run
