"""Sound of a robot's microphone: short packets of Opus, each heard on its own after the one before, or a sentence.

`docs/reference/channels.md` says the format; `tests/vectors/sound_packets.json` holds packets that Python and
TypeScript read alike.
"""

import struct
from dataclasses import dataclass

HEAD = struct.Struct("<BBBBIq")
TYPE = 5
RATE = 48_000  # samples a second, of one channel
LONGEST_MS = 120  # of one packet, as RFC 6716 allows
LARGEST = 4000  # bytes after the head


@dataclass(frozen=True)
class SoundPacket:
    """A packet: number, ms since 1970 when its sound began, how long it lasts (ms), Opus' bytes of it.

    Numbers count the time of the microphone up: one that is left out was never sent. `run` tells one opening of the
    microphone from another. One of 0 ms is a sentence in UTF-8 that says why nothing is heard now.
    """

    number: int
    at_ms: int
    ms: int
    data: bytes
    run: int = 0

    @property
    def text(self) -> str:
        """Return the sentence; empty for sound."""
        return "" if self.ms else self.data.decode()

    said = text  # its name in 0.1, until 1.0


def sentence(text: str, at_ms: int, number: int = 0, run: int = 0) -> SoundPacket:
    """Return the packet that says why nothing is heard."""
    return SoundPacket(number, at_ms, 0, text.encode()[:LARGEST].decode(errors="ignore").encode(), run)


def pack(packet: SoundPacket) -> bytes:
    """Return the packet's bytes. Raises ValueError if it is empty, too large or too long."""
    if not 0 < len(packet.data) <= LARGEST or not 0 <= packet.ms <= LONGEST_MS:
        raise ValueError(f"a packet of sound has 1 to {LARGEST} bytes and at most {LONGEST_MS} ms")
    number = packet.number & 0xFFFFFFFF
    return HEAD.pack(TYPE, packet.ms, packet.run & 0xFF, 0, number, packet.at_ms) + packet.data


def unpack(data: bytes) -> SoundPacket:
    """Return the packet. Raises ValueError for anything else."""
    if not HEAD.size < len(data) <= HEAD.size + LARGEST or data[0] != TYPE:
        raise ValueError("not a packet of sound")
    _, ms, run, _, number, at_ms = HEAD.unpack_from(data)
    rest = data[HEAD.size :]
    if ms > LONGEST_MS:
        raise ValueError("a packet of sound is too long")
    if not ms:
        rest.decode()  # raises UnicodeDecodeError, a ValueError
    return SoundPacket(number, at_ms, ms, rest, run)
