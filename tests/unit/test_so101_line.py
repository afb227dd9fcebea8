"""Bytes on the SO-101's line: whatever comes, the next good packet is answered, and the servos go on."""

import os

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from simulators.so101.__main__ import (
    EVERYBODY,
    FIRMWARE,
    NAMES,
    PING,
    READ,
    REGISTERS,
    SYNC_READ,
    SYNC_WRITE,
    WRITE,
    Simulator,
)  # fmt: skip

SERVOS = range(1, len(NAMES) + 1)


def packet(number, instruction, data=b""):
    return framed(bytes([number, len(data) + 2, instruction]) + data)


def framed(body):
    return b"\xff\xff" + body + bytes([~sum(body) & 0xFF])


class Line:
    """The other end of a simulator whose threads do not run."""

    def __init__(self, folder):
        self.sim = Simulator(folder)
        self.end = os.open(folder / "tty", os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)

    def say(self, data):
        """Return the answers to some bytes."""
        self.sim._take(data)
        found = b""
        try:
            while True:
                found += os.read(self.end, 65536)
        except BlockingIOError:
            return found

    def works(self):
        """Tell whether a servo answers, as it does not while it waits for the rest of a longer packet."""
        self.say(bytes(600))
        return self.say(packet(3, READ, b"\x00\x02")) == framed(bytes([3, 4, 0, *FIRMWARE]))


@pytest.fixture(scope="module")
def line(tmp_path_factory):
    return Line(tmp_path_factory.mktemp("so101"))


SHORT = {
    "read nothing": packet(1, READ), "read without a length": packet(1, READ, b"\x01"), "write nothing": packet(1, WRITE),
    "everybody writes nothing": packet(EVERYBODY, WRITE), "sync read": packet(EVERYBODY, SYNC_READ),
    "sync read without a length": packet(EVERYBODY, SYNC_READ, b"\x01"), "sync write": packet(EVERYBODY, SYNC_WRITE),
    "sync write without a length": packet(EVERYBODY, SYNC_WRITE, b"\x2a"), "length 0": framed(b"\xff\x00") + b"\x00",
    "length 1": framed(b"\x01\x01"), "write past the end": packet(1, WRITE, b"\x7f\x01\x02"),
    "write far past the end": packet(1, WRITE, b"\xf0" + b"\x01" * 100),
    "sync write past the end": packet(EVERYBODY, SYNC_WRITE, b"\x7f\x02\x01\x02\x03"),
}  # fmt: skip


@pytest.mark.parametrize("data", SHORT.values(), ids=SHORT)
def test_a_packet_that_is_too_short_or_writes_past_the_registers_is_noted_and_ignored(line, data):
    refused = line.sim.journal.counts["refused"]
    before = [bytes(servo.registers) for servo in line.sim._servos.values()]
    assert line.say(data) == b""
    assert line.works()
    assert line.sim.journal.counts["refused"] == refused + 1
    assert [bytes(servo.registers) for servo in line.sim._servos.values()] == before


def instructions():
    numbers = st.sampled_from([*SERVOS, EVERYBODY, 0, 7, 255])
    known = st.sampled_from([PING, READ, WRITE, SYNC_READ, SYNC_WRITE])
    return st.builds(packet, numbers, known | st.integers(0, 255), st.binary(max_size=250) | st.binary(max_size=4))


@settings(suppress_health_check=list(HealthCheck), max_examples=300)
@given(st.lists(instructions() | st.binary(max_size=20).map(framed) | st.binary(max_size=40), max_size=12))
def test_whatever_packets_come_the_next_one_is_answered(line, packets):
    line.say(b"".join(packets))
    for servo in line.sim._servos.values():
        servo.step()
    assert line.works()
    assert {len(servo.registers) for servo in line.sim._servos.values()} == {REGISTERS}


def test_answers_that_nobody_reads_are_lost(line):
    line.sim._take(packet(EVERYBODY, READ, b"\x00\x80") * 200)
    line.say(b"")
    assert line.works()
