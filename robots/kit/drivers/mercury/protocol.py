"""The Mercury arm's serial line, byte for byte; the only definition of the wire format.

Frame, in both directions: ``id, length, data[length], checksum``, the paper's four parts
(Goldberg et al. 1995, section 6.5: "instruction id, length, data and checksum", IEEE
floats). Ours: the first data byte is a sequence number, floats are little-endian binary32
and the checksum is a CRC-32, because a one-byte sum lets one broken frame in 256 pass.
There is no start byte. Every number is bounded here, where it is read.
"""

import contextlib
import struct
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from typing import Any, Literal

from robots.kit.drivers.mercury.beds import MOST_BEDS
from robots.kit.drivers.mercury.framing import GAP_S as GAP_S
from robots.kit.drivers.mercury.framing import Frame as Frame
from robots.kit.drivers.mercury.framing import FrameError as FrameError
from robots.kit.drivers.mercury.framing import Receiver as Receiver

BAUD = 4800
BITS_A_BYTE = 10  # 8 data bits, start and stop bit
BYTE_S = BITS_A_BYTE / BAUD


class NumberError(FrameError):
    """A number is not finite or impossibly large."""


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
    BURY = 0x16  # of a simulated bed alone


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
    """The activity of the controller."""

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


HOLD: int = Instruction.HOLD
RESET: int = Instruction.RESET
INSTRUCTIONS = frozenset(int(i) for i in Instruction)
REPLIES = frozenset(int(r) for r in Reply)

_XYZ = struct.Struct("<3f")
_FLOAT = struct.Struct("<f")
_NOTHING = struct.Struct("<")
_BOOT = struct.Struct("<I")
_REFUSAL = struct.Struct("<IB")
_END = struct.Struct("<I4f")
_STATE = struct.Struct("<IBBB4f")

# The content of each instruction, and the largest possible number: mm, deg, s, mm/s, or a bed's.
_CARRIES: dict[int, tuple[struct.Struct, float]] = {
    Instruction.MOVE_XYZ: (_XYZ, 10_000.0),
    Instruction.MOVE_THETA: (_FLOAT, 360.0),
    Instruction.AIR: (_FLOAT, 60.0),
    Instruction.SPEED: (_FLOAT, 10_000.0),
    Instruction.BURY: (_FLOAT, float(MOST_BEDS)),
    Instruction.RESET: (_NOTHING, 0.0),
    Instruction.CALIBRATE: (_NOTHING, 0.0),
    Instruction.STATUS: (_NOTHING, 0.0),
    Instruction.HOLD: (_NOTHING, 0.0),
}
JOINTS_WITHIN = 10_000.0  # deg and mm


def move_xyz(seq: int, x_mm: float, y_mm: float, z_mm: float) -> Frame:
    """Return the instruction to move the tool to (x, y, z) in mm; its world angle stays."""
    return Frame(Instruction.MOVE_XYZ, seq, _XYZ.pack(x_mm, y_mm, z_mm))


def scalar(instruction: Instruction, seq: int, value: float) -> Frame:
    """Return an instruction with one number: MOVE_THETA (deg), AIR (s), SPEED (mm/s), BURY (of a bed)."""
    return Frame(instruction, seq, _FLOAT.pack(value))


def numbers(frame: Frame) -> tuple[float, ...]:
    """Return the numbers of a known instruction, each within its bounds.

    Raises:
        FrameError: the length does not fit the instruction.
        NumberError: a number is not finite or impossibly large.
    """
    layout, greatest = _CARRIES[frame.id]
    return _bounded(_unpacked(layout, frame.payload), greatest)


def _unpacked(layout: struct.Struct, payload: bytes) -> tuple[Any, ...]:
    if len(payload) != layout.size:
        raise FrameError("length")
    return layout.unpack(payload)


def _bounded(values: tuple[float, ...], greatest: float) -> tuple[float, ...]:
    if not all(-greatest <= value <= greatest for value in values):  # NaN is outside every interval
        raise NumberError("number")
    return values


def _joints(values: tuple[float, ...]) -> tuple[float, float, float, float]:
    q1, q2, q3, q4 = _bounded(values, JOINTS_WITHIN)
    return q1, q2, q3, q4


@dataclass(frozen=True)
class ControllerState:
    """The content of STATE. Joints: q1 deg, q2 deg, q3 mm, q4 deg."""

    boot: int
    mode: Mode
    flags: Flag
    newest_seq: int
    joints: tuple[float, float, float, float]


def pack_state(seq: int, state: ControllerState) -> Frame:
    """Return a STATE reply: joints in degrees and mm, as the arm says them."""
    return Frame(
        Reply.STATE,
        seq,
        _STATE.pack(state.boot, state.mode, state.flags, state.newest_seq, *state.joints),
    )


def unpack_state(payload: bytes) -> ControllerState:
    """Return the state in a STATE reply. Raises FrameError, ValueError for an unknown mode."""
    boot, mode, flags, newest, *joints = _unpacked(_STATE, payload)
    return ControllerState(boot, Mode(mode), Flag(flags), newest, _joints(tuple(joints)))


def pack_ack(seq: int, boot: int) -> Frame:
    """Return the reply that an instruction was understood; `boot` counts the controller's starts."""
    return Frame(Reply.ACK, seq, _BOOT.pack(boot))


def pack_nak(seq: int, boot: int, error: Error) -> Frame:
    """Return the reply that an instruction is refused, and why."""
    return Frame(Reply.NAK, seq, _REFUSAL.pack(boot, error))


def unpack_nak(payload: bytes) -> tuple[int, int]:
    """Return (boot number, error) of a NAK reply. Raises FrameError for a wrong length."""
    boot, error = _unpacked(_REFUSAL, payload)
    return boot, error


def pack_end(reply: Reply, seq: int, boot: int, joints: tuple[float, float, float, float]) -> Frame:
    """Return a DONE or HELD reply."""
    return Frame(reply, seq, _END.pack(boot, *joints))


def unpack_end(payload: bytes) -> tuple[float, float, float, float]:
    """Return the joints in a DONE or HELD reply. Raises FrameError."""
    return _joints(_unpacked(_END, payload)[1:])


def boot_of(answer: Frame) -> int:
    """Return the boot number, the start of every reply. Raises FrameError for a malformed reply."""
    match answer.id:
        case Reply.ACK:
            (boot,) = _unpacked(_BOOT, answer.payload)
            return int(boot)
        case Reply.NAK:
            return unpack_nak(answer.payload)[0]
        case Reply.STATE:
            return unpack_state(answer.payload).boot
        case _:
            unpack_end(answer.payload)
            return int(_END.unpack(answer.payload)[0])


def newer(seq: int, than: int) -> bool:
    """Return whether `seq` comes after `than`; both 0 to 255, counted in a circle."""
    return 0 < (seq - than) % 256 < 128


def receiver() -> Receiver:
    """Return a receiver of replies."""
    return Receiver(REPLIES)


def status(seq: int) -> Frame:
    """Return the question for the state."""
    return Frame(Instruction.STATUS, seq)


def kind_of(reply: Frame) -> Literal["answer", "end", "state", "resend", "other"]:
    """Return what a reply is to its host. Raises FrameError for a malformed reply."""
    if reply.id not in REPLIES:
        return "other"
    boot_of(reply)
    match reply.id:
        case Reply.STATE:
            return "state"
        case Reply.DONE | Reply.HELD:
            return "end"
        case Reply.NAK if unpack_nak(reply.payload)[1] == Error.CHECKSUM:
            return "resend"
        case _:
            return "answer"


def state_of(reply: Frame) -> ControllerState:
    """Return the state in a STATE reply. Raises as `unpack_state`."""
    return unpack_state(reply.payload)


def refusal_of(answer: Frame) -> str:
    """Return why an answer refuses, empty if it does not."""
    if answer.id != Reply.NAK:
        return ""
    code = unpack_nak(answer.payload)[1]
    return ERROR_TEXT[Error(code)] if code in set(Error) else f"error {code}"


def spell(frame: Frame) -> str:
    """Return a frame of a known id as text; impossible numbers are left out."""
    names: type[Instruction] | type[Reply] = Reply if frame.id >= 0x80 else Instruction
    name = names(frame.id).name
    with contextlib.suppress(ValueError):
        if frame.id == Instruction.MOVE_XYZ:
            x, y, z = numbers(frame)
            return f"{name} #{frame.seq} x={x:.1f} y={y:.1f} z={z:.1f} mm"
        if frame.id in (Instruction.AIR, Instruction.SPEED, Instruction.MOVE_THETA, Instruction.BURY):
            return f"{name} #{frame.seq} {numbers(frame)[0]:.3f}"
        if frame.id == Reply.STATE:
            state = unpack_state(frame.payload)
            return f"{name} #{frame.seq} {state.mode.name} boot={state.boot}"
        if frame.id == Reply.NAK:
            return f"{name} #{frame.seq} {Error(unpack_nak(frame.payload)[1]).name}"
    return f"{name} #{frame.seq}"
