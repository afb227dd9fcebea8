"""The Mercury arm's serial line, byte for byte; the wire format's only home.

Frame, both ways: ``id, length, data[length], checksum``, the paper's four parts
(Goldberg et al. 1995, section 6.5: "instruction id, length, data and checksum", IEEE
floats). Ours: the first data byte is a sequence number, floats are little-endian binary32
and the checksum is a CRC-32, because a one-byte sum lets one broken frame in 256 pass.
There is no start byte; a receiver finds its place again after a gap in the line.
"""

import struct
import zlib
from dataclasses import dataclass
from enum import IntEnum, IntFlag

BAUD = 4800
BITS_A_BYTE = 10  # 8 data bits, start and stop bit
BYTE_S = BITS_A_BYTE / BAUD
GAP_S = 0.1  # silence after which a half-received frame is dropped (s)
HEAD = 2
CRC = struct.Struct("<I")
MAX_DATA = 48


class Instruction(IntEnum):
    """Host to controller. The first two are the paper's, the others ours."""

    MOVE_XYZ = 0x01
    MOVE_THETA = 0x02
    AIR = 0x10
    RESET = 0x11
    CALIBRATE = 0x12
    STATUS = 0x13
    SPEED = 0x14
    HOLD = 0x15


class Reply(IntEnum):
    """Controller to host. Acknowledgement and error are the paper's idea, the bytes ours."""

    ACK = 0x81  # seq, boot: understood, begun
    NAK = 0x82  # seq, boot, error
    DONE = 0x83  # seq, boot, joints: finished, set-point at rest
    HELD = 0x84  # seq, boot, joints: a motion was cut short by HOLD, set-point at rest
    STATE = 0x85  # seq, boot, mode, flags, newest seq, joints


class Error(IntEnum):
    """Why a controller refuses."""

    CHECKSUM = 1
    UNKNOWN_INSTRUCTION = 2
    BAD_LENGTH = 3
    OUT_OF_RANGE = 4
    NOT_CALIBRATED = 5
    BUSY = 6
    STALE_SEQUENCE = 7
    LIMIT_SWITCH = 8


ERROR_TEXT = {
    Error.CHECKSUM: "the checksum did not match",
    Error.UNKNOWN_INSTRUCTION: "the instruction is unknown",
    Error.BAD_LENGTH: "the length does not fit the instruction",
    Error.OUT_OF_RANGE: "the target is out of range",
    Error.NOT_CALIBRATED: "the controller is not calibrated",
    Error.BUSY: "the arm is already moving",
    Error.STALE_SEQUENCE: "the sequence number is older than one already seen",
    Error.LIMIT_SWITCH: "a limit switch was hit",
}


class Mode(IntEnum):
    """What the controller is doing."""

    IDLE = 0
    MOVING = 1
    HOLDING = 2
    CALIBRATING = 3
    BLOWING = 4


class Flag(IntFlag):
    """Conditions in a STATE reply."""

    NONE = 0
    CALIBRATED = 1
    LIMIT = 2


class FrameError(ValueError):
    """The bytes are no frame: wrong length or checksum."""


@dataclass(frozen=True)
class Frame:
    """One frame: id, sequence number, payload (data without the sequence number)."""

    id: int
    seq: int
    payload: bytes = b""

    def encode(self) -> bytes:
        """Return the bytes on the line."""
        body = bytes((self.id, len(self.payload) + 1, self.seq)) + self.payload
        return body + CRC.pack(zlib.crc32(body))


class Receiver:
    """Finds frames in a stream of bytes; broken ones are counted and dropped.

    A frame with a bad checksum drops one byte and looks again, so a doubled or lost byte
    costs no more than the frames it touched.
    """

    def __init__(self, known: frozenset[int]) -> None:
        self._known = known
        self._buffer = bytearray()
        self._last = 0.0
        self.broken = 0

    def feed(self, data: bytes, at: float) -> list[Frame]:
        """Return the frames completed by `data`, received at `at` (s, monotonic)."""
        if self._buffer and at - self._last > GAP_S:
            self.broken += 1
            self._buffer.clear()
        self._last = at
        self._buffer += data
        found: list[Frame] = []
        while len(self._buffer) >= HEAD:
            size = self._buffer[1]
            if self._buffer[0] not in self._known or not 1 <= size <= MAX_DATA:
                del self._buffer[0]
                continue
            if len(self._buffer) < HEAD + size + CRC.size:
                break
            body = bytes(self._buffer[: HEAD + size])
            (sent,) = CRC.unpack_from(self._buffer, HEAD + size)
            if zlib.crc32(body) != sent:
                self.broken += 1
                del self._buffer[0]
                continue
            del self._buffer[: HEAD + size + CRC.size]
            found.append(Frame(body[0], body[2], body[3:]))
        return found


INSTRUCTIONS = frozenset(int(i) for i in Instruction)
REPLIES = frozenset(int(r) for r in Reply)

_XYZ = struct.Struct("<3f")
_FLOAT = struct.Struct("<f")
_JOINTS = struct.Struct("<4f")
_STATE = struct.Struct("<BBBB4f")


def move_xyz(seq: int, x_mm: float, y_mm: float, z_mm: float) -> Frame:
    """Move the tool to (x, y, z) in mm, its world angle kept."""
    return Frame(Instruction.MOVE_XYZ, seq, _XYZ.pack(x_mm, y_mm, z_mm))


def scalar(instruction: Instruction, seq: int, value: float) -> Frame:
    """MOVE_THETA (deg), AIR (s), SPEED (mm/s)."""
    return Frame(instruction, seq, _FLOAT.pack(value))


def unpack_xyz(payload: bytes) -> tuple[float, float, float]:
    """Return (x, y, z) in mm. Raises FrameError for a wrong length."""
    if len(payload) != _XYZ.size:
        raise FrameError("length")
    x, y, z = _XYZ.unpack(payload)
    return x, y, z


def unpack_scalar(payload: bytes) -> float:
    """Return the one float of the payload. Raises FrameError for a wrong length."""
    if len(payload) != _FLOAT.size:
        raise FrameError("length")
    return float(_FLOAT.unpack(payload)[0])


@dataclass(frozen=True)
class ControllerState:
    """What STATE says. Joints: q1 deg, q2 deg, q3 mm, q4 deg."""

    boot: int
    mode: Mode
    flags: Flag
    newest_seq: int
    joints: tuple[float, float, float, float]


def pack_state(seq: int, state: ControllerState) -> Frame:
    """Return a STATE reply."""
    return Frame(
        Reply.STATE,
        seq,
        _STATE.pack(state.boot, state.mode, state.flags, state.newest_seq, *state.joints),
    )


def unpack_state(payload: bytes) -> ControllerState:
    """Return the state in a STATE reply. Raises FrameError for a wrong length."""
    if len(payload) != _STATE.size:
        raise FrameError("length")
    boot, mode, flags, newest, q1, q2, q3, q4 = _STATE.unpack(payload)
    return ControllerState(boot, Mode(mode), Flag(flags), newest, (q1, q2, q3, q4))


def pack_end(reply: Reply, seq: int, boot: int, joints: tuple[float, float, float, float]) -> Frame:
    """Return a DONE or HELD reply."""
    return Frame(reply, seq, bytes((boot,)) + _JOINTS.pack(*joints))


def unpack_end(payload: bytes) -> tuple[float, float, float, float]:
    """Return the joints in a DONE or HELD reply. Raises FrameError for a wrong length."""
    if len(payload) != 1 + _JOINTS.size:
        raise FrameError("length")
    q1, q2, q3, q4 = _JOINTS.unpack(payload[1:])
    return q1, q2, q3, q4


def newer(seq: int, than: int) -> bool:
    """Tell whether `seq` comes after `than`; both 0 to 255, counted round."""
    return 0 < (seq - than) % 256 < 128
