"""Frames of our commands behind `%`, and of their answers: a letter, a payload of bounded numbers, a checksum.

`%` LETTER payload `*` CRC `\\n` of at most 96 bytes goes to the rover, `##%` LETTER payload `*` CRC `\\r\\n` of at most
200 bytes comes back. The payload is printable ASCII without `*`. The CRC is XMODEM's (CCITT, from 0) of letter and
payload, as four hexadecimal digits, as the firmware has it for its flash buffer. Numbers are whole, with commas between
them.
"""

from binascii import crc_hqx
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from robots.kit.drivers.srv1.protocol import Malformed

LONGEST_COMMAND, LONGEST_ANSWER = 96, 200  # bytes, with everything
COMMAND, ANSWER = b"%", b"##%"
_ENDS = {COMMAND: b"\n", ANSWER: b"\r\n"}
_MOST = {COMMAND: LONGEST_COMMAND, ANSWER: LONGEST_ANSWER}
_CHECK = 5  # bytes of `*` and the checksum
MOST_DIGITS = 17  # with a sign


class Bounds(NamedTuple):
    """The least and the greatest value of a whole number; `milli`: of a thousandth of our unit."""

    low: int
    high: int
    milli: bool = False


EPOCH = Bounds(0, 2**53 - 1)
BOOT = Bounds(0, 2**32 - 1)
NUMBER = Bounds(0, 2**31)  # of motions, of entries
UPTIME_MS = Bounds(0, 2**40)
PERMIT_MS = Bounds(0, 600_000)  # what is left of it; a rover's own limit is in its description
MM = Bounds(-1_000_000, 1_000_000, milli=True)
MM_S = Bounds(-2000, 2000, milli=True)
MRAD = Bounds(-6284, 6284, milli=True)
MRAD_S = Bounds(-10_000, 10_000, milli=True)
RANGE_MM = Bounds(0, 100_000)
MV = Bounds(0, 60_000)
DECIDEGREES = Bounds(-1000, 2000)
THOUSANDTHS = Bounds(0, 1000)
FLAG = Bounds(0, 1)
SIDES = Bounds(0, 3)
CRC = Bounds(0, 0xFFFF)


def _bounded(value: int, bounds: Bounds) -> int:
    if not bounds.low <= value <= bounds.high:
        raise Malformed(f"{value} is not from {bounds.low} to {bounds.high}")
    return value


def encode_numbers(values: Sequence[int], bounds: Sequence[Bounds]) -> str:
    """Return numbers as text. Raises Malformed for one outside its bounds."""
    return ",".join(str(_bounded(value, limits)) for value, limits in zip(values, bounds, strict=True))


def numbers(payload: str, bounds: Sequence[Bounds]) -> list[int]:
    """Return exactly as many numbers as there are bounds. Raises Malformed, also for one outside its bounds."""
    parts = payload.split(",", len(bounds)) if payload else []
    if len(parts) != len(bounds):
        raise Malformed(f"{len(bounds)} numbers were expected in {payload[:40]!r}")
    return [_bounded(_number(part), limits) for part, limits in zip(parts, bounds, strict=True)]


def _number(text: str) -> int:
    digits = text.removeprefix("-")
    if not (digits.isascii() and digits.isdigit() and len(text) <= MOST_DIGITS):
        raise Malformed(f"{text[:40]!r} is no number")
    return int(text)


@dataclass(frozen=True)
class Frame:
    """A letter and its payload."""

    letter: str
    payload: str = ""

    def encode(self, start: bytes) -> bytes:
        """Return the frame that begins with `start`: COMMAND or ANSWER. Raises Malformed."""
        body = (self.letter + self.payload).encode("ascii", "replace")
        if len(self.letter) != 1 or not self.letter.isalpha() or not body.decode("ascii").isprintable() or b"*" in body:
            raise Malformed(f"this cannot be said in a frame: {(self.letter + self.payload)[:40]!r}")
        frame = b"%b%b*%04X%b" % (start, body, crc_hqx(body, 0), _ENDS[start])
        if len(frame) > _MOST[start]:
            raise Malformed(f"a frame of {len(frame)} bytes is longer than {_MOST[start]}")
        return frame

    @classmethod
    def decode(cls, data: bytes, start: bytes) -> "Frame":
        """Return the frame that these bytes are. Raises Malformed."""
        end = _ENDS[start]
        if len(data) > _MOST[start] or not (data.startswith(start) and data.endswith(end)):
            raise Malformed("this is no frame")
        inner = data[len(start) : -len(end)]
        body, check = inner[:-_CHECK], inner[-_CHECK:]
        if not body or check != b"*%04X" % crc_hqx(body, 0):
            raise Malformed("the checksum of a frame is wrong")
        text = body.decode("latin-1")
        if not (text.isascii() and text.isprintable() and text[0].isalpha()) or "*" in text:
            raise Malformed("a frame has other bytes than printable ASCII")
        return cls(text[0], text[1:])


class Frames:
    """Finds frames among other bytes, with a bounded memory. `start` is COMMAND or ANSWER."""

    def __init__(self, start: bytes) -> None:
        self._start, self._end, self._most = start, _ENDS[start], _MOST[start]
        self._rest = bytearray()
        self.malformed = 0  # what began as a frame and was none

    def feed(self, data: bytes) -> list[Frame]:
        """Take bytes; return the frames that are complete now, in order."""
        frames: list[Frame] = []
        rest = self._rest
        rest += data
        while True:
            at = rest.find(self._start)
            if at < 0:
                del rest[: max(0, len(rest) - len(self._start) + 1)]
                return frames
            del rest[:at]
            end = rest.find(self._end, 0, self._most)
            if end < 0 and len(rest) < self._most:
                return frames
            stop = end + len(self._end) if end >= 0 else 0
            try:
                frames.append(Frame.decode(bytes(rest[:stop]), self._start))
                del rest[:stop]
            except Malformed:
                self.malformed += 1
                del rest[:1]  # a true frame may begin within a false one
