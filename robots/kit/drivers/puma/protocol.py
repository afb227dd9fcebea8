"""The wire of the PUMA 560's controller, letter for letter; the only definition of the format.

Both directions carry lines of ASCII integers, code first, as the strings between the client and the server of Belousov
et al. 2001 do. The paper gives no table of codes and nothing of the serial line between server and controller, so all
of this is ours::

    :code sequence integer ... *checksum

A colon begins a line, wherever it comes, so a line that was cut off cannot hide the next one; a line feed ends it. The
checksum is CRC-16/XMODEM in four hexadecimal digits, over everything between colon and asterisk. Joints are told in
0.001 degrees, places in 0.01 mm, shares of full speed in thousandths, the controller's clock in 0.01 s. Every number is
bounded here, where it is read.
"""

import re
from binascii import crc_hqx
from collections.abc import Callable
from dataclasses import dataclass, fields
from enum import IntEnum, IntFlag
from math import degrees, radians
from typing import Literal, Self

BAUDS = (9600, 38400)
LONGEST = 140  # bytes of a line, with colon and line feed
MOST_NUMBERS = 16
SEQUENCES = 256
CLOCK = 1_000_000  # hundredths of a second after which the controller's clock begins again
TICK_S = 0.01
JOINTS = 6


class FormError(ValueError):
    """The numbers do not fit the code, or one of them is impossibly large."""


class Instruction(IntEnum):
    """Host to controller."""

    JOINTS = 1  # latest clock, share of full speed, six joints: turn them there
    POSE = 2  # latest clock, share of full speed, x y z, yaw pitch roll: bring the tool there
    LINE = 3  # as POSE, on a straight line of the tool
    JOG_JOINTS = 4  # latest clock, six velocities in 0.001 degrees/s; given again or the arm rests
    JOG_TOOL = 5  # latest clock, 0.01 mm/s along x y z, 0.001 degrees/s about x y z; given again as JOG_JOINTS
    GRIP = 6  # latest clock, 0 opens the fingers, 1 closes them
    CALIBRATE = 7  # latest clock: find the zeros of the joints
    RESET = 8  # as after power-on
    STATUS = 9  # answered by a STATE
    HOLD = 10  # come to rest now; read at any moment
    BOX = 11  # two corners in 0.01 mm: a forbidden box; without numbers: all of them are taken away


class Reply(IntEnum):
    """Controller to host."""

    ACK = 21  # boot, clock: understood
    NAK = 22  # boot, clock, error
    STATE = 23  # see State


class Error(IntEnum):
    """Why a controller refuses."""

    NONE = 0
    CHECKSUM = 1
    UNKNOWN_CODE = 2
    BAD_NUMBERS = 3
    OUT_OF_RANGE = 4
    IN_BOX = 5
    NOT_CALIBRATED = 6
    BUSY = 7
    STALE_SEQUENCE = 8
    TOO_LATE = 9
    FAULT = 10


ERROR_TEXT = {
    Error.NONE: "no reason was given",
    Error.CHECKSUM: "the checksum did not match",
    Error.UNKNOWN_CODE: "the code is unknown",
    Error.BAD_NUMBERS: "the numbers do not fit the code",
    Error.OUT_OF_RANGE: "the target is out of reach, or outside the range of a joint",
    Error.IN_BOX: "the arm would enter a forbidden box",
    Error.NOT_CALIBRATED: "the arm is not calibrated",
    Error.BUSY: "the arm is already moving",
    Error.STALE_SEQUENCE: "the sequence number is older than one already seen",
    Error.TOO_LATE: "the instruction came too late",
    Error.FAULT: "the arm has a fault; reset it first",
}


class Mode(IntEnum):
    """The activity of the controller."""

    IDLE = 0
    PLANNING = 1
    MOVING = 2
    JOGGING = 3
    HOLDING = 4
    CALIBRATING = 5


class Flag(IntFlag):
    """Conditions in a STATE."""

    NONE = 0
    CALIBRATED = 1
    FAULT = 2  # a joint left its range or did not follow, or the arm is in a forbidden box
    CLOSED = 4  # the gripper's valve; nobody knows what the fingers hold


class End(IntEnum):
    """How the newest motion ended."""

    NONE = 0
    DONE = 1
    HELD = 2
    REFUSED = 3


INSTRUCTIONS = frozenset(int(i) for i in Instruction)
REPLIES = frozenset(int(r) for r in Reply)
MOTIONS = frozenset({Instruction.JOINTS, Instruction.POSE, Instruction.LINE})
JOGS = frozenset({Instruction.JOG_JOINTS, Instruction.JOG_TOOL})

_CLOCK, _SHARE, _BIT = (0, CLOCK - 1), (1, 1000), (0, 1)
_ANGLE, _PLACE = (-720_000, 720_000), (-200_000, 200_000)
_BOOT, _CODE, _SEQUENCE = (0, 65_535), (0, 255), (0, SEQUENCES - 1)
_SIX_JOINTS, _SIX = (_ANGLE,) * JOINTS, (_PLACE,) * 3 + (_ANGLE,) * 3
_RANGES: dict[int, tuple[tuple[int, int], ...]] = {
    Instruction.JOINTS: (_CLOCK, _SHARE, *_SIX_JOINTS),
    Instruction.POSE: (_CLOCK, _SHARE, *_SIX),
    Instruction.LINE: (_CLOCK, _SHARE, *_SIX),
    Instruction.JOG_JOINTS: (_CLOCK, *_SIX_JOINTS),
    Instruction.JOG_TOOL: (_CLOCK, *_SIX),
    Instruction.GRIP: (_CLOCK, _BIT),
    Instruction.CALIBRATE: (_CLOCK,),
    Instruction.RESET: (),
    Instruction.STATUS: (),
    Instruction.HOLD: (),
    Instruction.BOX: (_PLACE,) * 6,
    Reply.ACK: (_BOOT, _CLOCK),
    Reply.NAK: (_BOOT, _CLOCK, _CODE),
    Reply.STATE: (_BOOT, _CLOCK, _CODE, _CODE, _SEQUENCE, _SEQUENCE, _CODE, _CODE, *_SIX_JOINTS),
}


@dataclass(frozen=True)
class Frame:
    """One line: code, sequence number, integers."""

    id: int
    seq: int
    numbers: tuple[int, ...] = ()

    def encode(self) -> bytes:
        """Return the bytes on the line."""
        body = f"{' '.join(map(str, (self.id, self.seq, *self.numbers)))} ".encode()
        return b":%b*%04X\n" % (body, crc_hqx(body, 0))

    def checked(self) -> tuple[int, ...]:
        """Return the numbers of a known code. Raises FormError: their count or a value does not fit it."""
        ranges = _RANGES[self.id]
        if self.id == Instruction.BOX and not self.numbers:
            return ()
        if len(self.numbers) != len(ranges):
            raise FormError("count")
        if not all(low <= number <= high for number, (low, high) in zip(self.numbers, ranges, strict=True)):
            raise FormError("value")
        return self.numbers


_LINE = re.compile(rb"((?:-?\d{1,9} ){2,18})\*([0-9A-F]{4})\r?")


class Receiver:
    """Finds lines in a stream of bytes. `broken` counts lines that are none, or have a wrong checksum.

    `on_broken` gets the sequence number of a line of a known code with a wrong checksum.
    """

    def __init__(self, known: frozenset[int], on_broken: Callable[[int], None] | None = None) -> None:
        self._known, self._on_broken = known, on_broken
        self._line: bytearray | None = None  # since its colon
        self.broken = 0

    def feed(self, data: bytes, at: float = 0.0) -> list[Frame]:
        """Return the lines that `data` completes; their codes may be unknown. When it came (`at`) does not matter."""
        found: list[Frame] = []
        for byte in data:
            if byte == 0x3A:  # a colon
                self.broken += bool(self._line)
                self._line = bytearray()
            elif self._line is not None and byte == 0x0A:
                frame = self._read(bytes(self._line))
                self._line = None
                if frame is not None:
                    found.append(frame)
            elif self._line is not None:
                self._line.append(byte)
                if len(self._line) > LONGEST:
                    self._line = None
                    self.broken += 1
        return found

    def _read(self, line: bytes) -> Frame | None:
        whole = _LINE.fullmatch(line)
        if whole is None:
            self.broken += 1
            return None
        body, told = whole.groups()
        code, seq, *numbers = map(int, body.split())
        if not 0 <= seq < SEQUENCES or code < 0:
            self.broken += 1
            return None
        if crc_hqx(body, 0) != int(told, 16):
            self.broken += 1
            if code in self._known and self._on_broken is not None:
                self._on_broken(seq)
            return None
        return Frame(code, seq, tuple(numbers))


@dataclass(frozen=True)
class State:
    """The numbers of a STATE.

    `newest`: the sequence number of the newest instruction; `motion`: of the newest motion, how it ended, and why if it
    was refused. `joints` are those that the encoders tell, in rad.
    """

    boot: int
    clock: int
    mode: Mode
    flags: Flag
    newest: int
    motion: int
    end: End
    why: Error
    joints: tuple[float, ...]

    def frame(self, seq: int) -> Frame:
        """Return the reply."""
        head = [int(getattr(self, f.name)) for f in fields(self)[:-1]]
        return Frame(Reply.STATE, seq, (*head, *map(thousandths, self.joints)))

    @classmethod
    def of(cls, frame: Frame) -> Self:
        """Return the state that a STATE tells. Raises FormError; ValueError for an unknown mode, end or error."""
        boot, clock, mode, flags, newest, motion, end, why, *joints = frame.checked()
        return cls(
            boot, clock, Mode(mode), Flag(flags & 7), newest, motion, End(end), Error(why),
            tuple(radians(joint / 1000) for joint in joints),
        )  # fmt: skip


def thousandths(angle: float) -> int:
    """Return an angle, or an angular velocity, in 0.001 degrees."""
    return round(1000 * degrees(angle))


def hundredths_mm(length: float) -> int:
    """Return a length (m), or a speed, in 0.01 mm."""
    return round(100_000 * length)


def boot_of(answer: Frame) -> int:
    """Return the boot number, the first number of every reply. Raises FormError."""
    return answer.checked()[0]


def clock_of(answer: Frame) -> int:
    """Return the controller's clock, the second number of every reply. Raises FormError."""
    return answer.checked()[1]


def error_of(nak: Frame) -> Error:
    """Return the reason of a NAK. Raises FormError, ValueError."""
    return Error(nak.checked()[2])


def newer(seq: int, than: int) -> bool:
    """Return whether `seq` comes after `than`; both 0 to 255, counted in a circle."""
    return 0 < (seq - than) % SEQUENCES < SEQUENCES // 2


def too_late(latest: int, clock: int) -> bool:
    """Return whether `clock` has passed `latest`; both in 0.01 s, counted in a circle."""
    return 0 < (clock - latest) % CLOCK < CLOCK // 2


# What `robots.kit.drivers.serial_line` needs of a protocol.

HOLD: int = Instruction.HOLD
RESET: int = Instruction.RESET


def receiver() -> Receiver:
    """Return a receiver of replies."""
    return Receiver(REPLIES)


def status(seq: int) -> Frame:
    """Return the question for the state."""
    return Frame(Instruction.STATUS, seq)


def kind_of(reply: Frame) -> Literal["answer", "end", "state", "resend", "other"]:
    """Return what a reply is to its host; ends of motions are told in states. Raises FormError, ValueError."""
    if reply.id not in REPLIES:
        return "other"
    reply.checked()
    if reply.id == Reply.STATE:
        return "state"
    return "resend" if reply.id == Reply.NAK and error_of(reply) == Error.CHECKSUM else "answer"


def state_of(reply: Frame) -> State:
    """Return the state in a STATE. Raises as `State.of`."""
    return State.of(reply)


def refusal_of(answer: Frame) -> str:
    """Return why an answer refuses, empty if it does not."""
    return ERROR_TEXT[error_of(answer)] if answer.id == Reply.NAK else ""


def spell(frame: Frame) -> str:
    """Return a frame of a known code as text; the wire is text already, so only its code is named."""
    names: type[Instruction] | type[Reply] = Reply if frame.id in REPLIES else Instruction
    return " ".join((f"{names(frame.id).name} #{frame.seq}", *map(str, frame.numbers)))
