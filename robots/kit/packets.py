"""Typed messages on the bus; unknown fields are refused, and docstrings name all units."""

import struct
from collections.abc import Mapping
from math import isfinite
from typing import Any

import msgspec

from robots.kit.contract.channels import Scalar, encode_values, float32
from robots.kit.contract.session import RobotState

STATE_HEAD = struct.Struct("<BBIqBB")
PICTURE_HEAD = struct.Struct("<BBIqIB")


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
    progress: dict[str, Any] = msgspec.field(default_factory=dict)
    target: dict[str, Any] = msgspec.field(default_factory=dict)


class Changed(_Message, frozen=True, tag="changed"):
    """The part `what` (robot, queue, log, frame, stop) of the robot changed and should be read again."""

    what: str


TAKEN_DOWN = Changed("picture taken down")  # what web processes keep of pictures may be it


class Trace(_Message, frozen=True, tag="trace"):
    """One frame on the robot's wire, for staff: direction, bytes in hex, words."""

    direction: str
    hex: str
    words: str
    at_ms: int
    resent: int = 0
    broken: int = 0


class Notice(_Message, frozen=True, tag="notice"):
    """A sentence for everybody who watches this robot."""

    text: str
    level: str = "info"


class StandingChanged(_Message, frozen=True, tag="standing"):
    """Places in this queue, or the places of this person, changed (ids; 0: none) and should be read again."""

    queue: int = 0
    user: int = 0


Event = CommandStage | Changed | Trace | Notice
encode = msgspec.json.Encoder().encode
_DECODER: msgspec.json.Decoder[Event] = msgspec.json.Decoder(Event)
_PEOPLE = msgspec.json.Decoder(StandingChanged)


def decode_standing(data: bytes) -> StandingChanged:
    """Return the decoded message. Raises msgspec.ValidationError for anything else."""
    return _PEOPLE.decode(data)


def decode(data: bytes) -> Event:
    """Return the event. Raises msgspec.ValidationError for anything unknown."""
    return _DECODER.decode(data)


def _floats(*rows: tuple[float, ...]) -> bytes:
    values = [float32(value) for row in rows for value in row]
    return struct.pack(f"<{len(values)}f", *values)


def state_packet(
    number: int, at_ms: int, state: RobotState, latched: bool, channels: tuple[Scalar, ...] = (),
    channel_values: Mapping[str, float] | None = None, twist: tuple[float, ...] = (),
) -> bytes:  # fmt: skip
    """Return type 1, flags, number, ms, number of joints and of rows, then float32s, channels and a word.

    Flags: 1 moving, 2 stop latched, 4 values of channels follow the rows (a byte of how many, float32s).

    The first row are the joints (rad, m); where the robot says them, two more follow: velocities
    (rad/s, m/s) and applied torques (N m, N). What is left is the controller's own word for what
    it is doing, in UTF-8. `channel_values` are values by name, if others than the state's own `values`
    are packed.
    `twist`, the body's velocity (m/s, rad/s), follows the channels and is counted with them (`Spec.body`).
    """
    count = len(state.joints)
    more = len(state.velocities) == count and len(state.torques) == count
    rows = (state.joints, state.velocities, state.torques) if more else (state.joints,)
    flags = state.moving | (latched << 1) | (bool(channels) << 2)
    head = STATE_HEAD.pack(1, flags, number & 0xFFFFFFFF, at_ms, count, len(rows))
    values = (
        encode_values(channels, state.values if channel_values is None else channel_values, twist) if channels else b""
    )
    return head + _floats(*rows) + values + state.mode.encode()


def picture_packet(
    number: int, at_ms: int, still: int, posture: tuple[float, ...], jpeg: bytes, camera: int = 0
) -> bytes:
    """Return type 2, camera, number, ms taken, id of the still of this pose (0: none), how many numbers, them, JPEG.

    The numbers say where the robot was (`Spec.posture`): joints, then coordinates of a pose and the body's velocity.
    """
    head = PICTURE_HEAD.pack(2, camera, number & 0xFFFFFFFF, at_ms, still, len(posture))
    return head + _floats(posture) + jpeg


def unpack_state(data: bytes) -> tuple[int, int, int, list[tuple[float, ...]], tuple[float, ...] | None, str]:
    """Return flags, number, ms, rows, values (None: none follow) and word of a state packet. Raises ValueError."""
    try:
        kind, flags, number, at_ms, count, rows = STATE_HEAD.unpack_from(data)
        floats = struct.unpack_from(f"<{count * rows}f", data, STATE_HEAD.size)
        at = STATE_HEAD.size + 4 * len(floats)
        values: tuple[float, ...] | None = None
        if flags & 4:
            values = struct.unpack_from(f"<{data[at]}f", data, at + 1)
            at += 1 + 4 * len(values)
        word = data[at:].decode()
    except (struct.error, IndexError, UnicodeDecodeError) as error:
        raise ValueError("not a packet of a state") from error
    if kind != 1:
        raise ValueError("not a packet of a state")
    return flags, number, at_ms, [floats[row * count :][:count] for row in range(rows)], values, word


def read_state(data: bytes, channels: tuple[Scalar, ...]) -> RobotState:
    """Return the state of a packet whose spec declares these channels; values that are not known are left out.

    Its `at` is the packet's stamp (s since 1970), its `ready` is not told. Raises ValueError for anything else.
    """
    flags, _, at_ms, rows, told, word = unpack_state(data)
    joints, values = rows[0] if rows else (), told or ()
    named = {channel.name: value for channel, value in zip(channels, values, strict=False) if isfinite(value)}
    twist = values[len(channels) :]
    return RobotState(at_ms / 1000, joints, (), bool(flags & 1), True, mode=word, values=named, twist=twist)


def taken_ms(data: bytes) -> int:
    """Return when the picture of a packet was taken, in ms since 1970. Raises ValueError."""
    read_picture(data)
    return int(PICTURE_HEAD.unpack_from(data)[3])


def read_picture(data: bytes) -> bytes:
    """Return the JPEG of a picture's packet. Raises ValueError."""
    if len(data) < PICTURE_HEAD.size or data[0] != 2:
        raise ValueError("not a packet of a picture")
    return data[PICTURE_HEAD.size + 4 * data[PICTURE_HEAD.size - 1] :]
