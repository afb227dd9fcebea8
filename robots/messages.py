"""Typed messages on the bus; unknown fields are refused, every unit is in a docstring."""

import struct
from typing import Any

import msgspec

STATE_PACKET = struct.Struct("<BBIq4h")
PICTURE_HEAD = struct.Struct("<BIqI4hH")
JOINT_SCALE = 10_000  # 1e-4 rad, 0.1 mm for the slide


class _Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="t"):
    pass


class CommandStage(_Message, frozen=True, tag="command"):
    """A command reached a stage. Times in ms since 1970."""

    id: int
    seq: int
    grant: int
    kind: str
    state: str
    reason: str = ""
    at_ms: int = 0
    result: dict[str, Any] = msgspec.field(default_factory=dict)


class Changed(_Message, frozen=True, tag="changed"):
    """Part `what` (robot, queue, log, frame, stop) of the robot changed: read it again."""

    what: str


class Trace(_Message, frozen=True, tag="trace"):
    """One frame on the robot's wire, for keepers: direction, bytes in hex, words."""

    way: str
    hex: str
    words: str
    at_ms: int
    resent: int = 0
    broken: int = 0


class Notice(_Message, frozen=True, tag="notice"):
    """A sentence for everybody who looks at this robot."""

    text: str
    level: str = "info"


Event = CommandStage | Changed | Trace | Notice
_ENCODER = msgspec.json.Encoder()
_DECODER: msgspec.json.Decoder[Event] = msgspec.json.Decoder(Event)


def encode(event: Event) -> bytes:
    """Return the event as JSON."""
    return _ENCODER.encode(event)


def decode(data: bytes) -> Event:
    """Return the event. Raises msgspec.ValidationError for anything unknown."""
    return _DECODER.decode(data)


def _scaled(joints: tuple[float, ...]) -> list[int]:
    return [max(-32768, min(32767, round(q * JOINT_SCALE))) for q in (*joints, 0, 0, 0, 0)[:4]]


def state_packet(number: int, at_ms: int, joints: tuple[float, ...], moving: bool, latched: bool) -> bytes:
    """Return 22 bytes: type 1, flags (1 moving, 2 stop latched), number, ms, 4 joints."""
    return STATE_PACKET.pack(1, moving | (latched << 1), number & 0xFFFFFFFF, at_ms, *_scaled(joints))


def picture_packet(number: int, at_ms: int, still: int, joints: tuple[float, ...], jpeg: bytes) -> bytes:
    """Return type 2, number, ms taken, id of the still this pose belongs to (0: none), joints, JPEG."""
    head = PICTURE_HEAD.pack(2, number & 0xFFFFFFFF, at_ms, still, *_scaled(joints), len(jpeg) & 0xFFFF)
    return head + jpeg
