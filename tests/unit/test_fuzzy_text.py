"""The text of a rule set, and the firmware's own parser and evaluator beside ours."""

from dataclasses import replace

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from robots.kit.drivers.srv1.rules import READINGS
from robots.kit.rovers.fuzzy import PAPER, speed
from robots.kit.rovers.fuzzy_text import LINES, LONGEST, parse, write
from simulators.srv1.rules import UNITS
from simulators.srv1.rules import RuleSet as Firmware
from tests.unit.fuzzy_sets import rule_sets

TEXT = write(PAPER)
LONG = ("aaaa-aaaa aaa", "bbbbbbbbbbbb", "cccccccccccc", "dddddddddddd", "eeeeeeeeeeee")


@given(rule_sets)
def test_a_text_gives_the_same_rule_set_back(rules):
    text = write(rules)
    assert parse(text) == rules
    assert len(text) <= LONGEST
    assert text.isascii()


def test_lines_may_stand_in_any_order_and_be_explained():
    lines = TEXT.splitlines()
    assert parse("# Night\n\n" + "\n".join(reversed(lines[4:])) + "\n" + "\n".join(reversed(lines[:4]))) == replace(
        PAPER,
        inputs=PAPER.inputs[::-1],
        table=tuple(zip(*PAPER.table, strict=True)),  # the inputs have changed places
    )


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("rule VF, N: S\n", "", r"Rule 22 \(infrared VF, sonar N\) is missing"),
        ("rule N, N: S", "rule VN, N: S", r"Rule 2 \(infrared VN, sonar N\) is given twice"),
        ("method sugeno", "method sugeno\nrule VN, N: S", r"Rule 2 \(infrared VN, sonar N\) is given twice"),
        ("rule N, N: S", "rule N, X: S", "The sonar has no term X"),
        ("rule N, N: S", "rule N, N: X", "The speed has no term X"),
        ("method sugeno", "method larsen", "no line of a rule set: 'method larsen'"),
        ("method sugeno\n", "", "one method, two inputs and one output"),
        ("method sugeno", "method sugeno\nmethod sugeno", "one method, two inputs and one output"),
        ("input sonar", "output sonar", "one method, two inputs and one output"),
        ("input sonar", "input infrared", "must be different"),
        ("N 0.3", "N nan", "The terms of the infrared"),
        ("N 0.3", "N 1e308", "The terms of the infrared"),
        ("N 0.3", "N inf", "The terms of the infrared"),
        ("N 0.3", "N 0.3001", "The terms of the infrared"),
        ("N 0.3", "N 99999", "The terms of the infrared"),
        ("N 0.3", "N 0.1", "The peaks of the infrared must rise; that of N does not"),
        ("N 0.3", "much too near 0.3", "The terms of the infrared"),
        ("N 0.3", "N0 0.3", "The terms of the infrared"),
        ("N 0.3, ", "", "needs 5 different terms"),
        ("N 0.3", "VN 0.3", "needs 5 different terms"),
        ("VF 0.4", "VF 0.6", "must lie in 0 to 0.5"),
        ("VS 0.08", "VS -0.08", "must lie in 0 to 0.5"),
        ("VF 0.4", "VF 0.325", "at least 0.01 m/s apart"),
        ("VF 0.75", "VF 0.7501", "The terms of the infrared"),
        ("VF 10", "VF 10000", "The terms of the sonar"),
        ("method sugeno", "method sugeno\r", "printable ASCII"),
        ("method sugeno", "# é\nmethod sugeno", "printable ASCII"),
        ("method sugeno", "# a\x00b\nmethod sugeno", "printable ASCII"),
        ("method sugeno", "# a\x1ab\nmethod sugeno", "printable ASCII"),
        ("method sugeno", "# a\tb\nmethod sugeno", "printable ASCII"),
        ("method sugeno", "# a\x7fb\nmethod sugeno", "printable ASCII"),
        ("method sugeno", "# \ud800\nmethod sugeno", "printable ASCII"),
    ],
)
def test_a_text_that_is_none_is_refused_by_both(old, new, why):
    assert old in TEXT
    with pytest.raises(ValueError, match=why):
        parse(TEXT.replace(old, new, 1))
    with pytest.raises(ValueError, match=r"\.$"):
        Firmware.parse(TEXT.replace(old, new, 1))


@pytest.mark.parametrize("reader", [parse, Firmware.parse])
def test_labels_are_short_and_different_also_where_every_rule_fits_them(reader):
    reader(TEXT.replace("VF", "much too far"))
    with pytest.raises(ValueError, match="label|terms"):
        reader(TEXT.replace("VF", "much too near"))
    with pytest.raises(ValueError, match="different terms"):
        reader(TEXT.replace(": S\n", ": M\n").replace(" S 0.16", " VS 0.16"))


@pytest.mark.parametrize("reader", [parse, Firmware.parse])
def test_a_text_is_bounded_before_it_is_parsed(reader):
    reader(TEXT + "#" * (LONGEST - len(TEXT)))
    reader(TEXT + "\n" * (LINES - 1 - TEXT.count("\n")))
    for much in ("#" * (LONGEST - len(TEXT) + 1), "\n" * (LINES - TEXT.count("\n")), "9" * 10**6):
        with pytest.raises(ValueError, match=r"at most|too long"):
            reader(TEXT + much)


def test_what_the_text_cannot_have_is_not_written():
    with pytest.raises(ValueError, match="The terms of the infrared"):
        write(replace(PAPER, inputs=(replace(PAPER.inputs[0], labels=("VN", "N", "M", "F", LONG[0])), PAPER.inputs[1])))
    with pytest.raises(ValueError, match="no line"):
        write(replace(PAPER, inputs=(replace(PAPER.inputs[0], unit="m\nrule"), PAPER.inputs[1])))
    long = [replace(v, labels=("aaaa-aa aaaa", *LONG[1:]), peaks=(-9999.111, -888.111, -77.111, -6.111, -5.111)) for v in PAPER.inputs]  # fmt: skip
    widest = replace(PAPER, inputs=tuple(long), output=replace(PAPER.output, labels=(*LONG[1:], "ffffffffffff")))
    assert parse(write(widest)) == widest


def test_driver_and_firmware_know_the_same_readings():
    assert READINGS == UNITS


def outcome(reader, text):
    try:
        return reader(text)
    except ValueError:
        return None


PIECES = st.sampled_from(
    [
        "",
        " ",
        ",",
        ":",
        "\n",
        "#",
        "-",
        ".",
        "0",
        "7",
        "VF",
        "rule ",
        "input ",
        "X" * 13,
        "é",
        "\x00",
        "\x1a",
        "\x7f",
        "%h*EDAE",
    ]
)


@given(st.lists(st.tuples(st.integers(0, len(TEXT)), st.integers(0, 3), PIECES), min_size=1, max_size=3))
@example([(0, 0, "\n")])
def test_both_parsers_take_and_refuse_the_same(changes):
    text = TEXT
    for at, gone, put in changes:
        text = text[:at] + put + text[at + gone :]
    ours, theirs = outcome(parse, text), outcome(Firmware.parse, text)
    if ours is not None and any(READINGS.get(v.name) != v.unit for v in ours.inputs):
        ours = None  # for want of such a reading, which the driver's check tells
    assert (ours is None) == (theirs is None)
    if ours is not None:
        assert theirs.inputs == tuple(v.name for v in ours.inputs)
        assert theirs.table == sum(ours.table, ())
        assert [theirs.first.peaks, theirs.second.peaks] == [
            tuple(round(1000 * p) for p in v.peaks) for v in ours.inputs
        ]


@given(rule_sets, st.data())
def test_the_firmware_gives_the_same_speed_within_2_mm_s(rules, data):
    theirs = Firmware.parse(write(rules))
    readings = []
    for variable in rules.inputs:
        low, high = round(1000 * variable.peaks[0]), round(1000 * variable.peaks[-1])
        readings.append(data.draw(st.integers(low - 50, high + 50)))
    found = theirs.speed_mm_s(*readings)
    assert type(found) is int
    assert found == pytest.approx(1000 * speed(rules, *(r / 1000 for r in readings)), abs=2)


@pytest.mark.parametrize("method", ["sugeno", "mamdani"])
def test_the_firmware_drives_the_papers_rules_as_we_do(method):
    rules = replace(PAPER, method=method)
    theirs = Firmware.parse(write(rules))
    assert theirs.inputs == ("infrared", "sonar")
    for first in range(0, 1000, 11):
        for second in range(0, 11000, 211):
            assert theirs.speed_mm_s(first, second) == pytest.approx(
                1000 * speed(rules, first / 1000, second / 1000), abs=1
            )


def test_the_firmwares_weights_are_fine_enough_for_a_narrow_triangle_beside_a_wide_one():
    first = replace(PAPER.inputs[0], peaks=(0, 2, 4, 6, 8))
    output = replace(PAPER.output, peaks=(0, 0.01, 0.02, 0.03, 0.5))
    table = ((0,) * 5, (4,) * 5, (1,) * 5, (4,) * 5, (3,) * 5)
    rules = replace(PAPER, inputs=(first, PAPER.inputs[1]), output=output, table=table, method="mamdani")
    theirs = Firmware.parse(write(rules))
    for reading in range(0, 8001, 13):
        assert theirs.speed_mm_s(reading, 2777) == pytest.approx(1000 * speed(rules, reading / 1000, 2.777), abs=2)


def test_the_checksum_is_that_of_the_text():
    assert Firmware.parse(TEXT).crc == bitwise(TEXT.encode())
    assert Firmware.parse(TEXT + "\n").crc == bitwise(TEXT.encode() + b"\n") != bitwise(TEXT.encode())


def bitwise(data):
    """Return the CRC-16 of XMODEM, bit by bit: polynomial 0x1021, from 0."""
    crc = 0
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = ((crc << 1) ^ (0x1021 if crc & 0x8000 else 0)) & 0xFFFF
    return crc
