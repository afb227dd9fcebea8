"""Frames of the Mercury arm's line: found in a stream of bytes, and encoded.

`protocol` describes their content.
"""

import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass

GAP_S = 0.1  # silence after which a half-received frame is dropped (s)
HEAD = 2
CRC = struct.Struct("<I")
MAX_DATA = 48
LONGEST = HEAD + MAX_DATA + CRC.size


class FrameError(ValueError):
    """The bytes are not a frame: wrong length or checksum."""


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
    """Finds frames in a stream of bytes, also between other bytes.

    Every byte may start a frame; the first complete one with the right checksum counts, so that a damaged or unfinished
    frame cannot hide a hold that follows it.
    """

    def __init__(self, known: frozenset[int], on_broken: Callable[[int], None] | None = None) -> None:
        """`on_broken` gets the number in a frame of a known id with a wrong checksum."""
        self._known = known
        self._on_broken = on_broken
        self._buffer = bytearray()
        self._last = 0.0
        self._in_step = True  # the buffer starts with a frame
        self.broken = 0

    def feed(self, data: bytes, at: float, until: float | None = None) -> list[Frame]:
        """Return the frames completed by `data`, received from `at` until `until` (s, monotonic).

        Their ids may be unknown.
        """
        if self._buffer and at - self._last > GAP_S:
            self.broken += 1
            self._buffer.clear()
        if not self._buffer:
            self._in_step = True
        self._last = at if until is None else until
        self._buffer += data
        found: list[Frame] = []
        while (frame := self._next()) is not None:
            found.append(frame)
        return found

    def _next(self) -> Frame | None:
        first = 0
        if self._in_step and (size := self._size(0)) is not None and not self._right(0, size):
            self._break()
            first = 1
        for i in range(first, len(self._buffer)):
            size = self._size(i)
            if size is not None and self._right(i, size):
                body = bytes(self._buffer[i : i + HEAD + size])
                self.broken += i > 0 and self._in_step
                del self._buffer[: i + HEAD + size + CRC.size]
                self._in_step = True
                return Frame(body[0], body[2], body[3:])
        if len(self._buffer) > LONGEST:
            self._in_step = False
            del self._buffer[:-LONGEST]
        return None

    def _size(self, i: int) -> int | None:
        """Return the length of the data of a frame that may start at `i`; None if there is none or it is incomplete."""
        if i + HEAD > len(self._buffer):
            return None
        size = self._buffer[i + 1]
        whole = 1 <= size <= MAX_DATA and i + HEAD + size + CRC.size <= len(self._buffer)
        return size if whole else None

    def _right(self, i: int, size: int) -> bool:
        (sent,) = CRC.unpack_from(self._buffer, i + HEAD + size)
        return bool(zlib.crc32(self._buffer[i : i + HEAD + size]) == sent)

    def _break(self) -> None:
        """Count a complete frame with a wrong checksum once, and look for the next one after its first byte."""
        self._in_step = False
        self.broken += 1
        if self._buffer[0] in self._known and self._on_broken is not None:
            self._on_broken(self._buffer[2])
