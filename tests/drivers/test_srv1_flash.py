"""The sending end of XMODEM against the firmware's receiving end, over the driver's own line."""

from binascii import crc_hqx

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robots.kit.contract.errors import LineSilent
from robots.kit.drivers.srv1 import flash
from robots.kit.drivers.srv1.extension import Activate
from robots.kit.drivers.srv1.line import RoverLine
from robots.kit.drivers.srv1.rules import crc_of, paper
from simulators.srv1.flash import CHECKED, Flash
from simulators.srv1.simulator import Simulator
from tests.drivers.srv1_wire import Rig
from tests.world.streams import Door, Network
from tests.world.world import World

TEXT = paper().encode()


class Pipe:
    """A connection in memory; `spoil` may change what is sent, or have it lost by returning nothing."""

    def __init__(self, rig):
        self.rig, self.sent, self.spoil = rig, [], lambda data: data

    def sendall(self, data):
        self.sent.append(data)
        self.rig.firmware.receive(self.spoil(data))

    def receive(self, most, seconds):
        rig = self.rig
        if not rig.world.park(rig.world.monotonic() + seconds, lambda: rig.heard):
            raise TimeoutError("timed out")
        data = bytes(rig.heard[:most])
        del rig.heard[:most]
        return data

    def close(self):
        pass


class Bed:
    """A rover on the bench with an open line; `noted` is called with each line of its trace."""

    def __init__(self):
        self.rig = Rig()
        self.pipe, self.noted = Pipe(self.rig), lambda way, data, words: None
        self.line = RoverLine(
            "bench", 1, lambda *told: self.noted(*told), self.rig.world, lambda host, port, seconds: self.pipe
        )
        self.line.open()
        self.pipe.sent.clear()

    @property
    def blocks(self):
        return [data for data in self.pipe.sent if data.startswith(flash.SOH) and len(data) == flash.BLOCK + 6]


@pytest.fixture
def bed():
    made = Bed()
    yield made
    made.rig.close()


def allowed():
    """Permit everything."""


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=30, deadline=None)
@given(st.binary(min_size=1, max_size=2048).filter(lambda data: not data.endswith(flash.FILL)))
def test_what_is_sent_is_in_the_flash_buffer_and_the_sums_agree(data):
    made = Bed()
    try:
        made.line.upload(data, allowed)
        buffer = bytes(made.rig.firmware.flash._buffer)
        assert buffer.startswith(data)
        assert crc_hqx(buffer[:CHECKED], 0) == flash.buffer_crc(data)
        assert made.line.status().uptime_ms > 0
    finally:
        made.rig.close()


def test_the_rules_that_were_sent_are_in_force(bed):
    bed.line.upload(TEXT, allowed)
    bed.line.ask(Activate(bed.line.epoch, crc_of(paper())))
    assert bed.line.status().rules == crc_of(paper())


def spoilt(bed, chosen, change):
    """Upload while the pieces of the chosen numbers are changed on their way, each once."""
    number = 0

    def spoil(data):
        nonlocal number
        number += 1
        return change(data) if number in chosen else data

    bed.pipe.spoil = spoil
    try:
        bed.line.upload(TEXT, allowed)
    finally:
        bed.pipe.spoil = lambda data: data


def flipped(data):
    return data[:40] + bytes((data[40] ^ 4,)) + data[41:]


def test_a_block_that_was_spoilt_is_sent_again_at_once(bed):
    before = bed.rig.world.monotonic()
    spoilt(bed, {3, 4, 6}, flipped)
    assert bed.rig.world.monotonic() - before < 0.5, "the firmware was not made to wait for a second of silence"
    assert bed.rig.firmware.flash.text() == TEXT
    assert len(bed.blocks) == len(flash.blocks(TEXT)) + 3


@pytest.mark.parametrize("number", range(1, 4 + len(flash.blocks(TEXT))))  # `X`, the blocks, the end, `zC`
@pytest.mark.parametrize("kept", [0, 1, 60, 130])
def test_after_an_upload_that_was_broken_off_the_line_is_in_order(bed, number, kept):
    with pytest.raises(LineSilent):
        spoilt(bed, {number}, lambda data: data[:kept] if len(data) > kept and data[:1] != flash.EOT else b"")
    assert bed.line.status().rules == 0
    bed.line.upload(TEXT, allowed)
    assert bed.rig.firmware.flash.text() == TEXT


@pytest.mark.parametrize("kept", [0, 1, 60, 130, 134])
@pytest.mark.parametrize("large", [False, True])
def test_a_reception_that_somebody_left_open_is_ended_by_who_connects(kept, large):
    made = Bed()
    try:
        made.line.close()
        made.rig.say(b"X")
        block = b"\x02" + bytes(range(1, 256)) * 5 if large else flash.blocks(TEXT)[0]
        made.rig.say(block[:kept])
        made.line.open()
        assert made.line.status().rules == 0
        assert made.rig.count("motion") == 0
    finally:
        made.rig.close()


@pytest.mark.parametrize("number", range(1, 1 + len(flash.blocks(TEXT))))
def test_nothing_is_sent_after_a_hold_that_no_open_reception_reads(bed, number):
    def noted(way, data, words):
        if way == ">" and words.endswith("of an upload") and len(bed.blocks) == number and not held:
            held.append(number)
            bed.rig.pass_s(0.01)  # it has said that it has this block
            bed.line.hold()

    held = []
    bed.noted = noted
    with pytest.raises(LineSilent):
        bed.line.upload(TEXT, allowed)
    assert len(bed.blocks) == number
    assert bed.line.status().rules == 0
    assert bed.rig.count("motion") == 0
    bed.line.upload(TEXT, allowed)


def test_what_the_permit_raises_ends_the_upload(bed):
    class Stop(Exception):
        pass

    calls = []

    def permit():
        calls.append(1)
        if len(calls) == 4:
            raise Stop

    with pytest.raises(Stop):
        bed.line.upload(TEXT, permit)
    assert len(bed.blocks) == 2
    assert bed.line.status().rules == 0


def test_a_rover_that_asks_for_ever_is_given_up(bed):
    bed.rig.firmware.stop()
    bed.rig.pass_s(0.1)
    bed.rig.world.spawn(lambda: chatter(bed.rig), "chatter")
    with pytest.raises(LineSilent):
        bed.line.upload(TEXT, allowed)
    assert len(bed.blocks) <= 1


def chatter(rig):
    while True:
        rig.hear(b"CCC")
        rig.world.sleep(0.01)


def test_by_radio_it_takes_a_second_and_what_is_broken_off_is_ended_too(tmp_path):
    """7 kbit/s, 37 ms a cycle: what ends a reception is on its way for longer than an answer may take."""
    world = World(1)
    cable = Network(world)
    sim = Simulator(tmp_path, 1, world, lambda: world.now().timestamp(), world, link="radio")
    line = RoverLine("rover:10001", 1, None, world, lambda host, port, seconds: cable.connect(host, port, seconds))
    sim.listen(Door(cable))
    world.spawn(sim.run, "simulator")
    try:
        world.sleep(1.5)
        line.open()
        at = world.monotonic()
        line.upload(TEXT, allowed)
        assert world.monotonic() - at < 1.5
        for number in range(1, 2 + len(flash.blocks(TEXT))):
            with pytest.raises(IndexError):
                line.upload(TEXT, ([None] * number).pop)  # so many permits
            assert line.status().rules == 0
            line.upload(TEXT, allowed)
        line.close()
        world.sleep(1)
        end = cable.connect("rover", 10001, 1.0)
        end.sendall(b"X")
        world.sleep(0.5)
        end.sendall(flash.blocks(TEXT)[0][:50])
        world.sleep(0.5)
        end.close()
        world.sleep(0.5)
        line.open()
        assert line.status().rules == 0
    finally:
        world.close()
        sim.journal.close()


def test_an_empty_buffer_has_the_sum_of_zeros():
    assert flash.buffer_crc(b"") == crc_hqx(bytes(CHECKED), 0)
    assert Flash().do(lambda: ord("C")) == b"##zCRC: 0x%x\r\n" % flash.buffer_crc(b"")
