"""Pictures of a camera as video: key frames, which stand alone, and pictures that change the one before.

`docs/reference/channels.md` says the format; `tests/vectors/video_packets.json` holds packets that Python and
TypeScript read alike.
"""

import struct
from dataclasses import dataclass

HEAD = struct.Struct("<BBBBIqI")
TYPE = 4
FARTHEST = 255  # between the numbers of two pictures of which one changes the other
GROUP_S = 2.0  # from one key frame to the next, if what lies between has more bytes than a key frame
LONGEST_S = 10.0  # and at most


@dataclass(frozen=True)
class VideoPacket:
    """One picture: camera, number, ms taken, id of the still of this pose (0: none), and the coded bytes of it.

    `follows` is the number of the picture that it changes; None for a key frame. Numbers count up, with gaps.
    `run` tells one run of an encoder from another: a picture follows pictures of the same run alone.
    """

    camera: int
    number: int
    at_ms: int
    still: int
    data: bytes
    follows: int | None = None
    run: int = 0

    @property
    def key(self) -> bool:
        """Tell whether it stands alone."""
        return self.follows is None


def pack(packet: VideoPacket) -> bytes:
    """Return the packet's bytes. Raises ValueError if the picture that it changes is too far back."""
    back = 0 if packet.follows is None else packet.number - packet.follows
    if packet.follows is not None and not 0 < back <= FARTHEST:
        raise ValueError(f"a picture follows one at most {FARTHEST} numbers before it")
    number = packet.number & 0xFFFFFFFF
    return HEAD.pack(TYPE, packet.camera, packet.run, back, number, packet.at_ms, packet.still) + packet.data


def unpack(data: bytes) -> VideoPacket:
    """Return the packet. Raises ValueError for anything else."""
    if len(data) <= HEAD.size or data[0] != TYPE:
        raise ValueError("not a packet of video")
    _, camera, run, back, number, at_ms, still = HEAD.unpack_from(data)
    follows = (number - back) & 0xFFFFFFFF if back else None
    return VideoPacket(camera, number, at_ms, still, data[HEAD.size :], follows, run)
