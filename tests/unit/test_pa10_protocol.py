"""The museum arm's lines: there and back, and nothing malformed gets through."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.drivers.pa10.protocol import FORMS, ArmState, End, Malformed, Mode, Request, parse, program

angle = st.floats(-6, 6)
six = st.tuples(*[angle] * 6)


@given(st.sampled_from("jkKlJC"), st.lists(st.floats(-1e4, 1e4), min_size=6, max_size=6))
def test_requests_there_and_back(letter, numbers):
    back = parse(Request(letter, tuple(numbers)).encode().decode())
    assert back.letter == letter
    assert back.numbers == pytest.approx(numbers, rel=1e-9)


@given(six, six, six, st.sampled_from(list(Mode)), st.sampled_from(list(End)), st.text("abc xyz", max_size=20))
def test_states_there_and_back(q, v, t, mode, end, note):
    note = " ".join(note.split())
    state = ArmState(mode, 3, end, 1, 0, 0, 1, 0.02, True, q, v, t, note)
    back = ArmState.decode(state.encode())
    assert back.q == pytest.approx(q, abs=1e-6)
    assert back.v == pytest.approx(v, abs=1e-4)
    assert back.torque == pytest.approx(t, abs=0.01)
    assert (back.mode, back.end, back.note) == (mode, end, note)


@given(st.text(max_size=300))
def test_anything_is_a_request_or_named(line):
    try:
        request = parse(line)
    except Malformed as error:
        assert str(error)
        return
    assert request.letter in FORMS
    assert all(math.isfinite(n) for n in request.numbers)


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("", "there is no command"),
        ("x 1", "there is no command 'x'"),
        ("j 1 2 3", "wants 6 or 7 values"),
        ("j 1 2 3 4 5 six", "'six' is no number"),
        ("j 1 2 3 4 5 nan", "no finite number"),
        ("g", "wants 1 values"),
        ("j " + "1" * 300, "longer than 200"),
    ],
)
def test_what_is_wrong_is_named(line, says):
    with pytest.raises(Malformed, match=says):
        parse(line)


def test_programs_are_written_out():
    steps = program("j 0 0 0 0 0 0\nR 2\n g 1 # close\nd 0.5\nE\nW")
    assert [s.letter for s in steps] == ["j", "g", "d", "g", "d", "W"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("w", "line 1: w cannot stand in a program"),
        ("g 1\nj 1", "line 2: j wants"),
        ("R 2\ng 1", "has no end"),
        ("E", "line 1: E ends a repetition"),
        ("R 100\nR 100\ng 1\nE\nE", "longer than 500"),
        ("R 0\nE", "1 to 100"),
    ],
)
def test_programs_that_are_wrong_are_named(text, says):
    with pytest.raises(Malformed, match=says):
        program(text)


def test_a_line_that_is_no_state():
    for line in ("s NO_CTRL", "ok 1", "s NO_CTRL motion=x end=done"):
        with pytest.raises(Malformed):
            ArmState.decode(line)
