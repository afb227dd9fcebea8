"""A key packet and the deltas after it, of a byte stream or of a camera's video; and how far a reader has read them."""

from collections.abc import Callable
from typing import NamedTuple

from robots.kit.contract.streams import StreamPacket
from robots.kit.contract.video import VideoPacket


class Cursor(NamedTuple):
    """A reader's position: the packets since one key packet, and how many of them it has read."""

    packets: list[bytes]
    position: int


START = Cursor([], 0)


class PacketChain:
    """The newest key packet and the deltas after it, each on the packet before. `unpack` reads a packet."""

    def __init__(self, unpack: Callable[[bytes], StreamPacket | VideoPacket]) -> None:
        self.packets: list[bytes] = []  # another list for each key packet, so that a cursor notices
        self.times: list[int] = []  # ms, of each
        self._unpack = unpack
        self._run = self._newest = 0

    def add(self, data: bytes) -> bool:
        """Add a packet; False for a delta that does not follow the newest one, which is left out. Raises ValueError."""
        packet = self._unpack(data)
        if packet.follows is None:
            self.packets, self.times, self._run = [], [], packet.run
        elif not self.packets or packet.run != self._run or packet.follows != self._newest:
            return False
        self.packets.append(data)
        self.times.append(packet.at_ms)
        self._newest = packet.number
        return True

    def clear(self) -> None:
        """Forget the packets: only a key packet may come next."""
        self.packets, self.times = [], []

    def position(self, cursor: Cursor) -> int:
        """Return how many of the packets a reader has."""
        return cursor.position if cursor.packets is self.packets else 0

    @property
    def end(self) -> Cursor:
        """Return the cursor of a reader that has all packets."""
        return Cursor(self.packets, len(self.packets))

    def has(self, data: bytes) -> bool:
        """Return whether a packet is one of these, where each delta is numbered one higher than the packet before."""
        packet = self._unpack(data)
        behind = (self._newest - packet.number) & 0xFFFFFFFF
        return packet.run == self._run and behind < len(self.packets)

    def restore(self, packets: list[bytes], newer: list[bytes]) -> None:
        """Take over a chain that was kept elsewhere, unless it is older than this one, then what was heard meanwhile.

        Raises ValueError.
        """
        kept = PacketChain(self._unpack)
        for data in packets:
            kept.add(data)
        if kept.packets and (kept.times[0], len(kept.packets)) > (self._begun_ms, len(self.packets)):
            self.packets, self.times, self._run, self._newest = kept.packets, kept.times, kept._run, kept._newest
        for data in newer:
            if self._unpack(data).at_ms >= self._begun_ms and not self.has(data):
                self.add(data)

    @property
    def _begun_ms(self) -> int:
        return self.times[0] if self.times else 0
