"""The byte streams of robots that somebody watches, kept once a process; viewers get them from the key packet on."""

from robots.kit.contract.packet_chain import START, Cursor, PacketChain
from robots.kit.contract.streams import MOST, unpack

EARLY = 64  # deltas kept while the packets before them are read from Redis


class Streams:
    """The byte streams of a hub's robots, as far as they are known."""

    def __init__(self) -> None:
        self._chains: dict[str, dict[int, PacketChain]] = {}
        self._early: dict[str, list[bytes]] = {}

    def take(self, slug: str, data: bytes) -> bool:
        """Take a packet; False if the packet before it was missed and has to be read. Raises ValueError."""
        chains = self._chains.get(slug)
        if chains is not None:
            chain = chains.setdefault(unpack(data).stream, PacketChain(unpack))
            if chain.add(data) or chain.has(data):
                return True
        self._early.setdefault(slug, []).append(data)
        del self._early[slug][:-EARLY]
        return False

    def restore(self, slug: str, stored: list[list[bytes]]) -> None:
        """Take over the packets of each stream that Redis keeps, then those heard meanwhile. Raises ValueError."""
        chains = self._chains.setdefault(slug, {})
        early = self._early.pop(slug, [])
        for index, packets in enumerate(stored[:MOST]):
            heard = [data for data in early if unpack(data).stream == index]
            if packets or heard:
                chains.setdefault(index, PacketChain(unpack)).restore(packets, heard)

    def news(self, slug: str, cursors: dict[int, Cursor]) -> list[bytes]:
        """Return the packets that a viewer does not have, and move its cursors; a slow one skips to the key packet."""
        new: list[bytes] = []
        for index, chain in self._chains.get(slug, {}).items():
            new += chain.packets[chain.position(cursors.get(index, START)) :]
            cursors[index] = chain.end
        return new

    def knows(self, slug: str) -> bool:
        """Return whether the packets that Redis keeps of that robot were read."""
        return slug in self._chains

    def forget(self, slug: str) -> None:
        """Forget a robot that nobody watches any more."""
        self._chains.pop(slug, None)
        self._early.pop(slug, None)
