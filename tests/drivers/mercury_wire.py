"""The Mercury arm's line spoken from its README alone: bytes, with nothing of the project's own protocol."""

import struct
import zlib

from tests.drivers import terminal

MOVE_XYZ, MOVE_THETA, AIR, RESET, CALIBRATE, STATUS, SPEED, HOLD, BURY = 1, 2, *range(0x10, 0x17)
ACK, NAK, DONE, HELD, STATE = 0x81, 0x82, 0x83, 0x84, 0x85
CHECKSUM, UNKNOWN, LENGTH, RANGE, NOT_CALIBRATED, BUSY, STALE = range(1, 8)


def frame(instruction: int, seq: int, data: bytes = b"") -> bytes:
    body = bytes((instruction, len(data) + 1, seq)) + data
    return body + struct.pack("<I", zlib.crc32(body))


def floats(*values: float) -> bytes:
    """Return binary32, little-endian; what is too large becomes infinite."""
    out = b""
    for value in values:
        try:
            out += struct.pack("<f", value)
        except OverflowError:
            out += struct.pack("<f", float("inf") if value > 0 else float("-inf"))
    return out


class Terminal(terminal.Terminal):
    """The arm's host; `heard` has (id, number, data)."""

    def _take(self) -> None:
        while (message := self._next()) is not None:
            self.heard.append((message[0], message[2], message[3:]))

    def _next(self) -> bytes | None:
        """Take the first whole message off what was received; before it may lie the rest of a message cut in two."""
        for start in range(len(self._rest) - 6):
            end = start + 2 + self._rest[start + 1]
            body, checksum = self._rest[start:end], self._rest[end : end + 4]
            if len(body) >= 3 and checksum == struct.pack("<I", zlib.crc32(body)):
                self._rest = self._rest[end + 4 :]
                return body
        return None

    def ask(self, instruction: int, seq: int, data: bytes = b""):
        """Send a frame; return the answer under its number as (id, error)."""
        self.heard.clear()
        self.write(frame(instruction, seq, data))

        def answer(heard):
            return next((h for h in heard if h[1] == seq and h[0] in (ACK, NAK, STATE)), None)

        found = self.until(answer)
        assert found, f"{instruction:#x} number {seq} was not answered"
        return found[0], found[2][-1] if found[0] == NAK else None

    def calibrated(self, seq: int) -> int:
        """Reset and calibrate under two numbers from `seq`; return the next one."""
        assert self.ask(RESET, seq)[0] == ACK
        assert self.ask(CALIBRATE, seq + 1)[0] == ACK
        assert self.ended(seq + 1, 6.0)[0] == DONE
        return seq + 2

    def ended(self, seq: int, seconds: float = 6.0):
        """Wait for DONE or HELD of a number."""
        found = self.until(
            lambda heard: next((h for h in heard if h[1] == seq and h[0] in (DONE, HELD)), None), seconds
        )
        assert found, f"number {seq} did not end"
        return found
