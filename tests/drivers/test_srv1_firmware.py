"""The traps of the rover's stock firmware, each as its source has it, in virtual time."""

import pytest

from robots.kit.drivers.srv1 import protocol
from robots.kit.drivers.srv1.extension import HOLD, Ask
from robots.kit.drivers.srv1.protocol import RESYNCHRONISE, PictureHeader
from tests.drivers.srv1_wire import BOOT, JPEG, Rig

pytestmark = pytest.mark.django_db(transaction=True)


@pytest.fixture(params=[True, False], ids=["stock", "ours"])
def rig(request):
    made = Rig(stock=request.param)
    yield made
    made.close()


@pytest.fixture
def stock():
    made = Rig(stock=True)
    yield made
    made.close()


def test_it_says_two_lines_when_it_starts_and_reads_nothing_before():
    rig = Rig(booted=False)
    rig.firmware.receive(b"V")
    rig.pass_s(0.9)
    assert not rig.heard
    rig.pass_s(0.2)
    assert rig.heard.startswith(BOOT)
    rig.heard.clear()
    rig.firmware.restart()
    rig.pass_s(1.1)
    assert bytes(rig.heard) == BOOT
    assert rig.say(b"$!", 1.1) == BOOT
    assert rig.firmware.boot == 3
    rig.close()


def test_a_motion_with_a_duration_reads_nothing_until_its_end_and_answers_then(rig):
    assert rig.say(protocol.motion(60, 60, 0.5), 0.4) == b""
    assert rig.bench.drive.moving
    assert rig.say(b"V", 0.05) == b"", "it waits, and is thrown away"
    assert rig.say(b"", 0.1) == b"#M"
    assert rig.say(b"", 1.0) == b""
    assert rig.rest() == "done"
    assert rig.bench.drive.motion == rig.count("motion") == 1


def test_after_every_command_all_waiting_bytes_are_thrown_away(rig):
    assert rig.say(b"Vp") == protocol_version(rig)
    assert rig.say(b"p", 0.02) == b""
    assert rig.say(b"V", 0.05).startswith(b"##ping")
    assert rig.say(b"") == b""


def protocol_version(rig):
    version = rig.say(b"V")
    assert "SRV-1 Blackfin" in protocol.version_of(version)
    return version


def test_a_command_that_is_cut_off_takes_a_stop_for_a_speed_of_53_per_cent(rig):
    rig.say(b"M", 60.0)  # for as long as one likes
    assert rig.say(b"5", 1.0) == b""
    assert rig.say(b"\x35\x64", 0.5) == b""
    assert rig.bench.drive.moving
    assert rig.bench.drive.target == pytest.approx((0.265, 0.265)), "0x35 is 53 per cent of 0.5 m/s"
    assert rig.say(b"", 1.0) == b"#M"


@pytest.mark.parametrize("cut", [b"M", b"M\x3c", b"M\x3c\x3c", b"F", b"F\x28", b"$", b"$A", b"$A0", b"z", b"q", b""])
def test_resynchronising_ends_whatever_was_cut_off_and_hardly_moves(rig, cut):
    rig.say(cut)
    rig.say(RESYNCHRONISE, 0.2)  # what it answers depends on what was cut off
    assert sum(map(abs, rig.bench.ways)) < 0.005
    assert rig.say(b"V").startswith(b"##Version")
    rig.rest() if rig.count("motion") else None


def test_the_failsafe_has_no_zero_and_comes_after_two_seconds_of_silence(rig):
    rig.say(protocol.motion(1, 1, 0.01))
    assert rig.say(protocol.failsafe(0, 40)) == b"#F"
    rig.pass_s(1.8)
    assert not rig.bench.drive.moving
    rig.pass_s(1.0)
    assert rig.bench.drive.target == pytest.approx((0.0, 0.2)), "0 becomes 1 per cent, which moves no wheel"
    assert rig.say(b"f") == b"#f"
    assert rig.say(b"5") == b"#5"
    rig.rest()
    rig.pass_s(10.0)
    assert rig.count("motion") == 1


def test_the_failsafe_does_nothing_before_the_first_motion(rig):
    rig.say(protocol.failsafe(60, 60))
    rig.pass_s(5.0)
    assert not rig.count("motion")


def test_a_motion_without_a_duration_runs_on(rig):
    assert rig.say(b"M\x3c\x3c\x00") == b"#M"
    rig.pass_s(30.0)
    assert rig.bench.drive.moving
    assert rig.say(b"5") == b"#5"
    assert rig.rest() == "done"


def test_the_keypad_is_acknowledged_and_ignored_before_the_first_motion(rig):
    for letter in b"0123456789.":
        assert rig.say(bytes((letter,)), 0.3) == b"#" + bytes((letter,))
    assert not rig.count("motion")
    rig.say(protocol.motion(1, 1, 0.01))
    assert rig.say(b"8", 0.5) == b"#8"
    assert rig.bench.drive.target == pytest.approx((0.2, 0.2)), "40 per cent"
    rig.say(b"+", 0.1)
    rig.say(b"6", 1.0)
    assert rig.bench.drive.target == pytest.approx((0.365, 0.065))
    rig.say(b"1", 2.0)
    assert rig.bench.drive.target == pytest.approx((-0.065, -0.365)), "-(speed - 30), -(speed + 30)"
    rig.say(b"5")
    rig.rest()
    rig.firmware.restart()
    rig.pass_s(1.1)
    assert rig.say(b"8", 1.0) == b"#8"
    assert rig.count("motion") == 1


@pytest.mark.parametrize(("letter", "sign"), [(b"0", 1), (b".", -1)])
def test_it_turns_by_about_twenty_degrees_and_reads_nothing_meanwhile(rig, letter, sign):
    rig.say(protocol.motion(1, 1, 0.01))
    before = rig.bench.heading
    assert rig.say(letter, 0.15) == b""
    assert rig.say(b"", 1.0) == b"#" + letter
    assert 0.2 < sign * (rig.bench.heading - before) < 0.5


def test_speeds_beyond_100_per_cent_are_clipped(rig):
    rig.say(bytes((ord("M"), 127, 128, 0)), 2.0)
    assert rig.bench.drive.target == pytest.approx((0.5, -0.5))
    assert not rig.count("passed")


def test_the_greatest_size_is_confirmed_as_d(rig):
    assert rig.say(b"A", 0.1) == rig.say(b"d", 0.1) == b"#d"
    assert rig.say(b"I", 0.1).startswith(b"##IMJ9")


def test_what_is_no_letter_is_told(rig):
    for letter in b"BCHKNUWZehjkuw\x00\x01\x80\xff":
        assert rig.say(bytes((letter,))) == b"#?"


def test_a_picture_has_a_header_with_its_length_low_byte_first(rig):
    data = rig.say(b"I", 0.1)
    assert data[:10] == b"##IMJ5" + len(JPEG).to_bytes(4, "little")
    assert data[10:] == JPEG
    assert PictureHeader.decode(data[:10]).length == len(JPEG)
    for letter, code in zip(b"abcd", b"3579", strict=True):
        rig.say(bytes((letter,)), 0.1)
        assert rig.say(b"I", 0.1)[5] == code
    rig.bench.seen = None
    assert rig.say(b"I", 1.0) == b"", "busy: it says nothing, and has to be asked again"


def test_pictures_that_are_cut_or_lie(rig):
    rig.bench.faults.set("half_frame", count=1)
    assert len(rig.say(b"I", 0.1)) == 10 + len(JPEG) // 2
    rig.bench.faults.set("lying_length", count=1)
    with pytest.raises(protocol.Malformed):
        PictureHeader.decode(rig.say(b"I", 0.1)[:10])
    assert PictureHeader.decode(rig.say(b"I", 0.1)[:10])


def test_the_sensors_answers_are_read_by_the_protocol(rig):
    assert protocol.sonar_of(rig.say(b"p", 0.1)) == pytest.approx(5.0, abs=2e-4)
    assert protocol.compass_of(rig.say(b"$C", 0.1)) == 90
    assert protocol.analogue_of(rig.say(b"$A02"), 2) == 419
    assert rig.say(b"$A09") == b"##$A9 65535\r\n"
    assert protocol.encoders_of(rig.say(b"$E", 0.1)) == (0, 0)
    assert not protocol.battery_is_low(rig.say(b"D"))
    rig.bench.volts = 6.5
    assert protocol.battery_is_low(rig.say(b"D"))
    assert rig.say(b"$z") == rig.say(b"<") == b""
    rig.say(b"M\xc4\x3c\x00", 1.0)
    left, right = protocol.encoders_of(rig.say(b"$E", 0.1))
    assert left == right == pytest.approx(0.3 * 400 / 0.2827, abs=26), "pulses a second, without a sign"


def test_a_stock_rover_is_silent_to_what_is_ours(stock):
    assert stock.say(b"%h") == b"myfunc:  hello ! \r\n"
    assert stock.ask(Ask()) is None
    assert stock.say(b"%x") == b""
    stock.say(b"M\x3c\x3c\x00", 0.5)
    assert stock.say(HOLD) == b"myfunc:  hello ! \r\n", "and it drives on"
    assert stock.bench.drive.moving


def test_bytes_beyond_its_room_are_lost_and_the_rest_is_read(rig):
    rig.say(protocol.motion(1, 1, 0.5), 0.0)
    rig.firmware.receive(b"V" * 100_000)
    rig.pass_s(1.0)
    assert bytes(rig.heard) == b"#M"
    assert rig.say(b"V").startswith(b"##Version")
