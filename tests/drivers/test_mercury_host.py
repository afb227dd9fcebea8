"""The host's end of the Mercury arm's line against a controller that says anything."""

import math
import os
import pty
import struct
import threading
import time
import tty

import pytest
from hypothesis import given, seed
from hypothesis import strategies as st

from robots.kit.clock import FasterTimer
from robots.kit.contract.errors import ControllerRefused, LineGone, LineSilent
from robots.kit.drivers.mercury import protocol as wire
from robots.kit.drivers.mercury.protocol import Instruction
from robots.kit.drivers.serial_line import SerialLine
from tests.conftest import wait_for
from tests.drivers.fuzzing import numbers, rounds
from tests.drivers.mercury_wire import ACK, CHECKSUM, DONE, HELD, NAK, STATE, floats, frame

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

PACE = 4  # times real time: the pace of the host's limits
BOOT = struct.pack("<I", 7)


class Controller:
    """The other end of a pty: `say` writes, `answer` is asked for each instruction (id, number, data)."""

    def __init__(self):
        self.master, slave = pty.openpty()
        tty.setraw(slave)
        self.path, self._slave = os.ttyname(slave), slave
        self.heard, self.answer = [], lambda frame: b""
        self._open = True
        threading.Thread(target=self._listen, daemon=True).start()

    def say(self, data):
        os.write(self.master, data)

    def _listen(self):
        receiver = wire.Receiver(wire.INSTRUCTIONS)
        while self._open:
            try:
                data = os.read(self.master, 4096)
            except OSError:
                return
            for one in receiver.feed(data, time.monotonic()):
                self.heard.append(one)
                self.say(self.answer(one))

    def close(self):
        self._open = False
        os.close(self._slave)
        os.close(self.master)


@pytest.fixture(scope="module")
def ends():
    controller = Controller()
    seen = []
    line = SerialLine(wire, controller.path, wire.BAUD, 10, lambda *what: seen.append(what), FasterTimer(PACE))
    line.open()
    yield controller, line
    line.close()
    controller.close()


def state(joints=(50.0, 100.0, 75.0, 0.0), mode=0):
    return BOOT + bytes((mode, 1, 3)) + floats(*joints)


def well(controller, line):
    """Fail unless the reader lives and takes an honest answer."""
    controller.answer = lambda f: frame(STATE, f.seq, state())
    line.boot = None
    assert line.status().boot == 7
    assert line.status().joints == pytest.approx((50.0, 100.0, 75.0, 0.0))


ids = st.one_of(st.sampled_from([ACK, NAK, DONE, HELD, STATE]), st.integers(0, 255))
said = st.one_of(
    st.binary(max_size=60),
    st.builds(frame, ids, st.integers(0, 255), st.binary(max_size=40)),
    st.builds(lambda i, s, v: frame(i, s, BOOT + floats(*v)), ids, st.integers(0, 255), st.tuples(*[numbers()] * 4)),
    st.builds(
        lambda s, m, v: frame(STATE, s, state(v, m)),
        st.integers(0, 255),
        st.integers(0, 255),
        st.tuples(*[numbers()] * 4),
    ),
)


@seed(44)
@rounds(200)
@given(st.lists(said, max_size=12))
def test_whatever_a_controller_says_the_host_listens_on(ends, rubbish):
    controller, line = ends
    controller.say(b"".join(rubbish))
    well(controller, line)


def test_a_reader_that_fails_loses_the_line_and_lets_nobody_wait(monkeypatch):
    controller = Controller()
    controller.answer = lambda f: frame(STATE, f.seq, state())
    line = SerialLine(wire, controller.path, wire.BAUD, 10, None, FasterTimer(PACE))
    line.open()
    try:
        monkeypatch.setattr(line, "_heard", lambda frame: {}["a fault of ours"])
        with pytest.raises(LineGone):
            line.status()
        monkeypatch.undo()
        line.close()
        line.open()
        well(controller, line)
    finally:
        line.close()
        controller.close()


@pytest.mark.parametrize("value", [math.nan, math.inf, 1e30, 1e308])
def test_joints_that_cannot_be_are_no_answer(ends, value):
    controller, line = ends
    controller.answer = lambda f: (
        frame(STATE, f.seq, state((value, 0, 0, 0))) + frame(DONE, f.seq, BOOT + floats(value, 0, 0, 0))
    )
    line.boot = None
    with pytest.raises(LineSilent):
        line.status()
    well(controller, line)


def speeds(frames):
    """Return those that set a speed; a question for the state may have come again where its answer was late."""
    return [f for f in frames if f.id == Instruction.SPEED]


def test_a_refused_checksum_is_answered_by_the_same_bytes_at_once(ends, monkeypatch):
    controller, line = ends
    well(controller, line)
    controller.heard.clear()
    tries = iter(range(100))

    def answer(f):
        if not speeds([f]):
            return frame(STATE, f.seq, state())
        return frame(NAK, f.seq, BOOT + bytes((CHECKSUM,))) if next(tries) < 3 else frame(ACK, f.seq, BOOT)

    controller.answer = answer
    slow = FasterTimer(0.01)  # a silence lasts half a minute
    monkeypatch.setattr(line, "_clock", slow)
    begun = slow.monotonic()
    line.instruct(lambda seq: wire.scalar(Instruction.SPEED, seq, 100.0), None)
    heard = speeds(controller.heard)
    assert len({f.encode() for f in heard}) == 1
    assert len(heard) == 4
    assert slow.monotonic() - begun < 0.3, "it did not wait for a silence"


def test_checksums_refused_for_ever_end_after_eleven_tries(ends):
    controller, line = ends
    well(controller, line)
    controller.heard.clear()
    controller.answer = lambda f: frame(NAK, f.seq, BOOT + bytes((CHECKSUM,)))
    with pytest.raises(LineSilent, match="11 tries"):
        line.instruct(lambda seq: wire.scalar(Instruction.SPEED, seq, 100.0), None)
    wait_for(lambda: len(speeds(controller.heard)) >= 11, 5, "the eleventh")
    assert len(speeds(controller.heard)) == 11


@pytest.mark.parametrize("error", [2, 3, 4, 8, 99])
def test_other_refusals_end_it_in_words(ends, error):
    controller, line = ends
    well(controller, line)
    controller.answer = lambda f: frame(NAK, f.seq, BOOT + bytes((error,)))
    with pytest.raises(ControllerRefused, match="refused"):
        line.instruct(lambda seq: wire.scalar(Instruction.SPEED, seq, 100.0), None)
