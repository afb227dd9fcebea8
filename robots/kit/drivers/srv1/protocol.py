"""The SRV-1's published letters, for driver and simulator alike: commands out, answers in.

The Surveyor SRV-1 Blackfin's protocol document and its firmware of March 2011 differ in small ways ("##Ping" and
"##ping", "##A" and "##$A"); the decoders understand both. Speeds of the motors are per cent, signed bytes.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass

PORT = 10001
UNKNOWN = b"#?"  # the answer to a letter that is none
VERSION, GRAB, SONAR, COMPASS, ENCODERS, BATTERY = b"V", b"I", b"p", b"$C", b"$E", b"D"
STOP, TURN_LEFT, TURN_RIGHT = b"5", b"0", b"."  # the two turn by about 20 degrees each
NO_FAILSAFE = b"f"
RECEIVE, CHECKSUM = b"X", b"zC"  # of the flash buffer
# Ends a command that was cut off, whatever arguments it lacks: each byte is 1 % as a speed, which moves nothing, 10 ms
# as a duration, and unknown as a letter. It is never 00, which as a duration has no end. All bytes go in one write:
# the firmware throws away those that the command does not take.
RESYNCHRONISE = b"\x01" * 5
FASTEST = 100  # per cent, of a motor
DURATION_S, LONGEST_S = 0.01, 2.55  # the unit of a motion's duration, and the longest
FAILSAFE_S = 2.0  # of silence, after which it takes the failsafe speeds
QUALITIES = range(1, 9)  # of pictures; 1 is the best
CHANNELS = frozenset((*range(1, 9), *range(11, 19), *range(21, 29)))  # analogue, of three converters
HEADER, HEADER_BYTES = b"##IMJ", 10
MOST_PICTURE, LONGEST_LINE = 200_000, 200  # bytes
METRES_A_PING = 0.0254 / 100  # the sonar counts hundredths of an inch


class Malformed(ValueError):
    """The bytes are no message of this protocol; the sentence says why."""


@dataclass(frozen=True)
class Size:
    """A size of pictures: the letter that asks for it, the code in their header, and pixels."""

    letter: bytes
    code: bytes
    width: int
    height: int


SIZES = (
    Size(b"a", b"3", 160, 120),
    Size(b"b", b"5", 320, 240),
    Size(b"c", b"7", 640, 480),
    Size(b"d", b"9", 1280, 1024),
)


def size_of(width: int) -> Size:
    """Return the size with this width (pixels). Raises Malformed."""
    for size in SIZES:
        if size.width == width:
            return size
    raise Malformed(f"there are no pictures of {width} pixels across; there are {[s.width for s in SIZES]}")


def _speed(per_cent: int, least: int = -FASTEST) -> int:
    if not (isinstance(per_cent, int) and least <= per_cent <= FASTEST):
        raise Malformed(f"a motor's speed is a whole number from {least} to {FASTEST} %, not {per_cent!r}")
    return per_cent % 256


def motion(left: int, right: int, seconds: float) -> bytes:
    """Return `M`: both sides at so many per cent for 0.01 to 2.55 s; the robot reads nothing meanwhile.

    A duration of 0, with which it would run on for ever, is refused. Raises Malformed.
    """
    if not DURATION_S <= seconds <= LONGEST_S:  # also if it is NaN
        raise Malformed(f"a motion lasts from {DURATION_S} to {LONGEST_S} s, not {seconds}")
    return bytes((ord("M"), _speed(left), _speed(right), round(seconds / DURATION_S)))


def failsafe(left: int, right: int) -> bytes:
    """Return `F`: the speeds (%) after 2 s without a command. The robot takes 1 for 0. Raises Malformed."""
    return bytes((ord("F"), _speed(left), _speed(right)))


def analogue(channel: int) -> bytes:
    """Return the question for an analogue channel. Raises Malformed."""
    if channel not in CHANNELS:
        raise Malformed(f"there is no analogue channel {channel!r}; there are 1 to 8, 11 to 18 and 21 to 28")
    return b"$A%02d" % channel


def quality(level: int) -> bytes:
    """Return `q`: 1 is the best, 8 the smallest picture. Raises Malformed."""
    if level not in QUALITIES:
        raise Malformed(f"the quality of pictures is from 1 to 8, not {level!r}")
    return b"q%d" % level


def acknowledgement(command: bytes) -> bytes:
    """Return the answer to a command that is confirmed by its letter; `A` is confirmed as `d`."""
    return b"#" + command[:1].replace(b"A", b"d")


def confirms(command: bytes) -> Callable[[bytes], bool | None]:
    """Return a function that tells whether the bytes so far confirm that command; None: not yet."""
    done = acknowledgement(command)
    return lambda said: True if done in said else None


@dataclass(frozen=True)
class PictureHeader:
    """The head before the bytes of a JPEG: its size code and its length (bytes)."""

    size: Size
    length: int

    def encode(self) -> bytes:
        """Return the ten bytes; the length's low byte is first."""
        return HEADER + self.size.code + self.length.to_bytes(4, "little")

    @classmethod
    def decode(cls, data: bytes) -> "PictureHeader":
        """Return the header that ten bytes are. Raises Malformed, also for a length that no picture has."""
        if len(data) != HEADER_BYTES or not data.startswith(HEADER):
            raise Malformed("this is no header of a picture")
        code, length = data[5:6], int.from_bytes(data[6:], "little")
        size = next((size for size in SIZES if size.code == code), None)
        if size is None:
            raise Malformed(f"there is no size of pictures with the code {code!r}")
        if not 0 < length <= MOST_PICTURE:
            raise Malformed(f"a picture has from 1 to {MOST_PICTURE} bytes, not {length}")
        return cls(size, length)


def _matched(pattern: str, line: bytes, what: str) -> re.Match[str]:
    if len(line) > LONGEST_LINE:
        raise Malformed(f"a line of {len(line)} bytes is too long for {what}")
    text = line.decode("latin-1").strip()
    match = re.fullmatch(pattern, text, re.IGNORECASE | re.ASCII)
    if match is None:
        raise Malformed(f"{text[:40]!r} does not tell {what}")
    return match


def version_of(line: bytes) -> str:
    """Return what the firmware calls itself. Raises Malformed."""
    return _matched(r"##?Version\s*[-:]?\s*(\S.{0,150}?)", line, "a version")[1]


def sonar_of(line: bytes) -> float:
    """Return the distance (m) that the first transducer hears. Raises Malformed."""
    match = _matched(r"##?ping:?((?:\s+\d{1,6}){1,4})", line, "the sonar's distances")
    return int(match[1].split()[0]) * METRES_A_PING


def analogue_of(line: bytes, channel: int) -> int:
    """Return the counts, 0 to 4095, of the channel that was asked for. Raises Malformed."""
    match = _matched(r"##?\$?A(\d{1,2})?:?\s+(\d{1,5})", line, "an analogue channel")
    if match[1] is not None and int(match[1]) != channel:
        raise Malformed(f"channel {int(match[1])} was told and {channel} was asked for")
    if int(match[2]) > 4095:
        raise Malformed(f"channel {channel} is not there")
    return int(match[2])


def encoders_of(line: bytes) -> tuple[int, int]:
    """Return the pulses a second of the left and the right wheels, without a sign. Raises Malformed."""
    pattern = r"##?\$?E(?:ncoders)?:?\s*(?:left\s*=\s*)?(\d{1,9})[\s,]+(?:right\s*=\s*)?(\d{1,9})"
    match = _matched(pattern, line, "the encoders")
    return int(match[1]), int(match[2])


def compass_of(line: bytes) -> int:
    """Return the heading in degrees, clockwise from north, 0 to 359. Raises Malformed."""
    degrees = int(_matched(r"##?\$?C(?:ompass)?:?\s*(\d{1,3})", line, "a heading")[1])
    if degrees >= 360:  # firmwares tell 999 for a compass that does not answer
        raise Malformed(f"there is no heading of {degrees} degrees")
    return degrees


def battery_is_low(line: bytes) -> bool:
    """Return whether the battery is low, which is all that `D` tells. Raises Malformed."""
    match = _matched(r"##?D\b\s*-?\s*(?:battery voltage\s*)?(low|okay|ok)\b.{0,60}", line, "the battery")
    return match[1].lower() == "low"


def checksum_of(line: bytes) -> int:
    """Return the CRC of the flash buffer (without its last 8 bytes). Raises Malformed."""
    return int(_matched(r"##?zCRC:?\s*(?:0x)?([0-9a-f]{1,4})", line, "a checksum")[1], 16)


def count_of(line: bytes) -> int:
    """Return how many bytes were received, written to flash, or read from it. Raises Malformed."""
    spellings = r"Xmodem (?:success\. count|transfer count)|zread count|zwrite count"
    return int(_matched(rf"##?(?:{spellings}):?\s*(\d{{1,7}})", line, "a number of bytes")[1])
