"""The PUMA 560's line spoken from the description of its protocol alone, with nothing of the project's own."""

import re
import time  # noqa: TID251 - the limit of a wait
from binascii import crc_hqx

from tests.drivers import terminal

JOINTS, POSE, LINE, JOG_JOINTS, JOG_TOOL, GRIP, CALIBRATE, RESET, STATUS, HOLD, BOX = range(1, 12)
ACK, NAK, STATE = 21, 22, 23
CHECKSUM, UNKNOWN, NUMBERS, RANGE, IN_BOX, NOT_CALIBRATED, BUSY, STALE, LATE, FAULT = range(1, 11)
IDLE, PLANNING, MOVING, JOGGING, HOLDING, CALIBRATING = range(6)
DONE, HELD, REFUSED = 1, 2, 3
CLOCK = 1_000_000  # the clock's circle, in 0.01 s
REPLY = re.compile(rb":((?:-?\d+ )+)\*([0-9A-F]{4})\n")
Reply = tuple[int, ...]  # code, number, boot, clock, more


def line(code: int, seq: int, *numbers: int) -> bytes:
    body = "".join(f"{number} " for number in (code, seq, *numbers)).encode()
    return b":" + body + b"*%04X\n" % crc_hqx(body, 0)


class Terminal(terminal.Terminal):
    """The arm's host; `heard` has replies."""

    def _take(self) -> None:
        for found in REPLY.finditer(self._rest):
            body, told = found.groups()
            if crc_hqx(body, 0) == int(told, 16):
                self.heard.append(tuple(map(int, body.split())))
        self._rest = self._rest[self._rest.rfind(b"\n") + 1 :]

    def answer(self, seq: int) -> Reply:
        found = self.until(lambda heard: next((one for one in heard if one[1] == seq), None))
        assert found, f"number {seq} was not answered"
        return found

    def ask(self, code: int, seq: int, *numbers: int) -> tuple[int, int | None]:
        """Send a line; return the answer under its number as (code, error)."""
        self.heard.clear()
        self.write(line(code, seq, *numbers))
        found = self.answer(seq)
        return found[0], found[4] if found[0] == NAK else None

    def state(self, seq: int = 0) -> Reply:
        """Return boot, clock, mode, flags, newest, motion, end, why, and six joints (0.001 degrees)."""
        self.heard.clear()
        self.write(line(STATUS, seq))
        return self.answer(seq)[2:]

    def latest(self, seconds: float = 5.0) -> int:
        return (self.state()[1] + round(100 * seconds)) % CLOCK

    def ended(self, seconds: float = 20.0) -> Reply:
        """Ask for states until the arm does nothing; return the last one."""
        end = time.monotonic() + seconds
        while (state := self.state())[2] != IDLE:
            assert time.monotonic() < end, state
        return state

    def calibrated(self, seq: int) -> int:
        """Reset and calibrate under two numbers from `seq`; return the next one."""
        assert self.ask(RESET, seq)[0] == ACK
        assert self.ask(CALIBRATE, (seq + 1) % 256, self.latest())[0] == ACK
        assert self.ended()[3] & 1
        return (seq + 2) % 256
