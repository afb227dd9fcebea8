"""The packets of a broadcast: a head of 22 bytes, a tag of 8, and some bytes of one segment.

| bytes | what |
|---|---|
| 1 | kind and version, 0xF1 |
| 4 | the movie, by its content: the beginning of its SHA-256 |
| 8 | number: of an origin it grows by one a packet, and never goes back while its clock does not |
| 1 | how long a joiner waits, in tenths of a second |
| 2 | segment; 0 is the index |
| 3, 3 | where in the segment the bytes begin; how many bytes the segment has |
| 8 | tag: keyed BLAKE2s of the bytes before it and of those of the segment |

Big-endian. Every host of the network can send to the group, in anybody's name. So a packet is read only if its tag fits
the key that origin and edges share; the tag also shows changes on the way.
"""

import hashlib
import hmac
import struct
from dataclasses import dataclass

DATAGRAM = 1372  # bytes: with UDP's and IP's headers 1400, which also passes through most tunnels
HEAD = struct.Struct(">BIQBHHBHB")  # the two numbers of 3 bytes as 2 + 1
TAG = 8  # bytes
PAYLOAD = DATAGRAM - HEAD.size - TAG
UDP_IP = 28  # bytes of the headers before each packet (IPv4)
VERSION = 0xF1
LARGEST = 2**24 - 1  # bytes of a segment
SEGMENTS = 3601  # of a movie at most: an hour in slots of a second, and the index
SHORTEST_KEY = 16  # characters


@dataclass(frozen=True)
class Packet:
    """Bytes of a segment of a movie, from `offset` on, of `size` in all; `wait_ds` in tenths of a second."""

    movie: int
    number: int
    wait_ds: int
    segment: int
    offset: int
    size: int
    data: bytes


def key_of(secret: str) -> bytes:
    """Return the key that a secret text stands for. Raises ValueError where it is too short."""
    if len(secret) < SHORTEST_KEY:
        raise ValueError(f"The key of a broadcast needs at least {SHORTEST_KEY} characters.")
    return hashlib.sha256(secret.encode()).digest()


def tag(key: bytes, *parts: bytes) -> bytes:
    """Return the tag of some bytes."""
    made = hashlib.blake2s(key=key, digest_size=TAG)
    for part in parts:
        made.update(part)
    return made.digest()


def movie_of(contents: tuple[bytes, ...]) -> int:
    """Return the number of a movie that has these segments."""
    made = hashlib.sha256()
    for content in contents:
        made.update(len(content).to_bytes(4, "big"))
        made.update(content)
    return int.from_bytes(made.digest()[:4], "big")


def encode(key: bytes, packet: Packet) -> bytes:
    """Return the packet as it is sent."""
    head = HEAD.pack(
        VERSION, packet.movie, packet.number, packet.wait_ds, packet.segment,
        packet.offset >> 8, packet.offset & 255, packet.size >> 8, packet.size & 255,
    )  # fmt: skip
    return head + tag(key, head, packet.data) + packet.data


def decode(key: bytes, datagram: bytes) -> Packet | None:
    """Return the packet of a datagram; None if it is no packet, or not of an origin with this key."""
    begin = HEAD.size + TAG
    if not begin < len(datagram) <= DATAGRAM:
        return None
    head, data = datagram[: HEAD.size], datagram[begin:]
    if not hmac.compare_digest(tag(key, head, data), datagram[HEAD.size : begin]):
        return None
    version, movie, number, wait_ds, segment, offset, low, size, size_low = HEAD.unpack(head)
    packet = Packet(movie, number, wait_ds, segment, offset << 8 | low, size << 8 | size_low, data)
    if version != VERSION or not wait_ds or segment >= SEGMENTS or packet.offset + len(data) > packet.size:
        return None
    return packet


def range_tag(key: bytes, movie: int, segment: int, offset: int, size: int, data: bytes) -> str:
    """Return the tag of bytes that are fetched by HTTP, from `offset` on, of a segment of `size` bytes."""
    return tag(key, b"range", struct.pack(">IHII", movie, segment, offset, size), data).hex()
