"""The rover's published letters: what is encoded can be read, both spellings are understood, and garbage is refused."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.description import load
from robots.kit.drivers.srv1 import protocol, sensors
from robots.kit.drivers.srv1.protocol import HEADER_BYTES, MOST_PICTURE, SIZES, Malformed, PictureHeader, size_of
from simulators.srv1.motors import signed

per_cent = st.integers(-100, 100)
DECODERS = (
    protocol.version_of, protocol.sonar_of, lambda line: protocol.analogue_of(line, 1), protocol.encoders_of,
    protocol.compass_of, protocol.battery_is_low, protocol.checksum_of, protocol.count_of,
)  # fmt: skip


@given(per_cent, per_cent, st.floats(0.01, 2.55))
def test_a_motion_is_read_as_the_firmware_reads_it_and_always_ends(left, right, seconds):
    letter, first, second, duration = protocol.motion(left, right, seconds)
    assert (letter, signed(first), signed(second)) == (ord("M"), left, right)
    assert duration * 0.01 == pytest.approx(seconds, abs=0.0051)
    assert duration >= 1


@given(per_cent, per_cent)
def test_failsafe_speeds_are_signed(left, right):
    assert [signed(byte) for byte in protocol.failsafe(left, right)[1:]] == [left, right]


@pytest.mark.parametrize("seconds", [0.0, -1.0, 2.56, math.nan, math.inf, 1e308])
def test_a_motion_without_an_end_cannot_be_said(seconds):
    with pytest.raises(Malformed):
        protocol.motion(50, 50, seconds)


@pytest.mark.parametrize("speed", [101, -101, 10**30, 0.5, math.nan, "5"])
def test_a_speed_that_is_none_is_refused(speed):
    for command in (lambda: protocol.motion(speed, 0, 1.0), lambda: protocol.failsafe(0, speed)):
        with pytest.raises(Malformed):
            command()


def test_resynchronising_is_harmless_in_every_place():
    assert 0 not in protocol.RESYNCHRONISE
    assert all(signed(byte) == 1 for byte in protocol.RESYNCHRONISE)
    assert len(protocol.RESYNCHRONISE) >= 3


@given(st.sampled_from(SIZES), st.integers(1, MOST_PICTURE))
def test_a_header_is_read_as_it_was_written(size, length):
    header = PictureHeader(size, length)
    data = header.encode()
    assert len(data) == HEADER_BYTES
    assert data[6:8] == bytes((length & 255, length >> 8 & 255))
    assert PictureHeader.decode(data) == header


@given(st.integers(MOST_PICTURE + 1, 2**32 - 1) | st.just(0), st.sampled_from(SIZES))
def test_a_length_that_no_picture_has_is_refused(length, size):
    with pytest.raises(Malformed):
        PictureHeader.decode(PictureHeader(size, length).encode())


@given(st.binary(max_size=12))
def test_what_is_no_header_is_refused(data):
    with pytest.raises(Malformed):
        PictureHeader.decode(data)
    with pytest.raises(Malformed):
        PictureHeader.decode(b"##IMJ4" + data[:4].ljust(4, b"\1"))


def test_sizes_are_named_by_their_width():
    assert [(s.letter, s.code) for s in SIZES] == [(b"a", b"3"), (b"b", b"5"), (b"c", b"7"), (b"d", b"9")]
    assert size_of(320).height == 240
    with pytest.raises(Malformed):
        size_of(321)


@pytest.mark.parametrize(
    "line", [b"##ping 1000 0 0 0\r\n", b"##Ping 1000\r\n", b"##Ping 1000 2 3 4", b"##ping: 1000\n"]
)
def test_both_spellings_of_the_sonar(line):
    assert protocol.sonar_of(line) == pytest.approx(0.254)


@pytest.mark.parametrize("line", [b"##$A4 0512\r\n", b"##$A 0512\r\n", b"##A04 0512\r\n", b"##$A04 512"])
def test_both_spellings_of_an_analogue_channel(line):
    assert protocol.analogue_of(line, 4) == 512


@pytest.mark.parametrize("line", [b"##$A5 0512\r\n", b"##$A4 65535\r\n", b"##$A4\r\n", b"##$A4 -1\r\n"])
def test_an_analogue_answer_that_is_not_the_one_asked_for(line):
    with pytest.raises(Malformed):
        protocol.analogue_of(line, 4)


@pytest.mark.parametrize(
    "line", [b"##$Encoders:  left = 12  right = 7\r\n", b"##$Encoders: left = 12 right = 7", b"##$E 12 7", b"##E 12, 7"]
)
def test_both_spellings_of_the_encoders(line):
    assert protocol.encoders_of(line) == (12, 7)


@pytest.mark.parametrize("line", [b"##$C  90\r\n", b"##C 90\r\n", b"##$C 090", b"##compass: 90"])
def test_both_spellings_of_the_compass(line):
    assert protocol.compass_of(line) == 90


def test_a_compass_that_does_not_answer_is_no_heading():
    with pytest.raises(Malformed):
        protocol.compass_of(b"##$C 999\r\n")


@pytest.mark.parametrize(
    ("line", "low"),
    [(b"##D - low battery voltage detected\r\n", True), (b"##D - battery voltage okay\r\n", False), (b"##D ok", False)],
)
def test_the_battery(line, low):
    assert protocol.battery_is_low(line) is low


def test_versions_checksums_and_counts():
    assert protocol.version_of(b"##Version - SRV-1 Blackfin built:1\r\n") == "SRV-1 Blackfin built:1"
    assert protocol.version_of(b"##Version: 2.0\n") == "2.0"
    assert protocol.checksum_of(b"##zCRC: 0xbeef\r\n") == 0xBEEF
    assert protocol.count_of(b"##Xmodem success. Count: 256\r\n") == 256
    assert protocol.count_of(b"#Xmodem transfer count: 256\r\n") == 256
    assert protocol.count_of(b"##zwrite count: 65536\r\n") == 65536


@given(st.binary(max_size=300) | st.text(max_size=60).map(lambda text: b"##" + text.encode("utf-8", "replace")))
def test_garbage_is_refused_and_nothing_else_is_raised(line):
    for decode in DECODERS:
        try:
            value = decode(line)
        except Malformed:
            continue
        assert line.lstrip().startswith(b"#"), value


@pytest.mark.parametrize(
    "line", [b"##ping " + b"9" * 100_000, b"##ping" + b" " * 100_000, b"#" * 100_000, b"##ping \xb2"]
)
def test_an_endless_line_is_refused(line):
    for decode in DECODERS:
        with pytest.raises(Malformed):
            decode(line)


@pytest.mark.parametrize("channel", [0, 9, 10, 19, 29, -1, 10**20])
def test_a_channel_that_is_not_there_is_refused(channel):
    with pytest.raises(Malformed):
        protocol.analogue(channel)


def test_questions_have_two_digits():
    assert protocol.analogue(4) == b"$A04"
    assert protocol.analogue(28) == b"$A28"
    assert protocol.quality(8) == b"q8"
    with pytest.raises(Malformed):
        protocol.quality(9)
    assert protocol.acknowledgement(b"A") == b"#d"
    assert protocol.acknowledgement(protocol.motion(1, 1, 1.0)) == b"#M"


@given(st.floats(0.1, 0.8), st.floats(-20, 80), st.floats(0, 1))
def test_counts_of_a_sensor_mean_what_was_measured(metres, celsius, share):
    infrared = load("srv1")["infrared"]
    seen = sensors.infrared_m(sensors.infrared_counts(metres, infrared["near"]), infrared)
    assert seen == pytest.approx(metres, abs=0.005)
    assert sensors.temperature_c(sensors.temperature_counts(celsius)) == pytest.approx(celsius, abs=0.06)
    assert sensors.share(sensors.share_counts(share)) == pytest.approx(share, abs=0.001)


@given(st.integers(-(10**9), 10**9))
def test_whatever_a_converter_says_is_a_distance_that_the_sensor_has(counts):
    infrared = load("srv1")["infrared"]
    assert infrared["near"] <= sensors.infrared_m(counts, infrared) <= infrared["far"]
