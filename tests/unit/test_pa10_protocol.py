"""The museum arm's lines: there and back, and nothing malformed gets through."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.drivers.pa10.forms import FORMS
from robots.kit.drivers.pa10.protocol import ArmState, End, Malformed, Mode, Request, parse, program

angle = st.floats(-6, 6)
six = st.tuples(*[angle] * 6)


@given(st.sampled_from("jkKlJC"), st.lists(st.floats(-720, 720), min_size=6, max_size=6))
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
        ("j 1 2 3", "needs 6 or 7 values"),
        ("j 1 2 3 4 5 six", "'six' is not a number"),
        ("j 1 2 3 4 5 nan", "is not a number"),
        ("g", "needs 1 values"),
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
        ("g 1\nj 1", "line 2: j needs"),
        ("R 2\ng 1", "has no end"),
        ("E", "line 1: E ends a repetition"),
        ("R 100\nR 100\ng 1\nE\nE", "longer than 500"),
        ("R 0\nE", "line 1: R: the number of repetitions is 0; it must be a whole number from 1 to 100"),
        ("R 1.5\nE", "whole number"),
        ("d 31", "line 1: d: the wait is 31 s; it must be from 0 to 30 s"),
        ("R 1\n" * 9, "at most 8 deep"),
        ("# x\n" * 9000, "longer than 20000 characters"),
    ],
)
def test_programs_that_are_wrong_are_named(text, says):
    with pytest.raises(Malformed, match=says):
        program(text)


def test_a_line_that_is_no_state():
    for line in ("s NO_CTRL", "ok 1", "s NO_CTRL motion=x end=done"):
        with pytest.raises(Malformed):
            ArmState.decode(line)


@pytest.mark.asvs("1.3.3", "1.4.2")
@pytest.mark.parametrize("letter", [letter for letter, form in FORMS.items() if form.values])
@given(data=st.data())
def test_no_number_outside_its_bounds_is_read(letter, data):
    """Each value in turn, to 1e308 and past it; the sentence names value, range and unit."""
    form = FORMS[letter]
    which = data.draw(st.integers(0, len(form.values) - 1))
    value = form.values[which]
    outside = st.floats(min_value=math.nextafter(value.high, math.inf)) | st.floats(
        max_value=math.nextafter(value.low, -math.inf)
    )
    parts = [repr(v.low) for v in form.values]
    parts[which] = repr(data.draw(outside))
    word = " box" if letter == "b" else ""
    with pytest.raises(Malformed) as raised:
        parse(f"{letter} {' '.join(parts)}{word}", stored=not form.alone)
    said = str(raised.value)
    assert "no number" in said or (
        value.name in said and f"to {value.high:.0f}" in said and said.endswith(value.unit)
    ), said


@pytest.mark.parametrize("letter", "dRE")
def test_what_stands_in_a_program_only_is_no_line(letter):
    with pytest.raises(Malformed, match="in a program only"):
        parse(f"{letter} 1")


@given(st.integers(0, 2**53 - 1))
def test_an_epoch_is_kept_to_the_last_digit(epoch):
    assert int(parse(Request("i", (float(epoch),)).encode().decode()).numbers[0]) == epoch


STATE = ArmState(Mode.NO_CTRL, 3, End.DONE, 1, 0, 0, 1, 0.02, False, (0.1,) * 6, (0.0,) * 6, (1.0,) * 6, "")
WILD = ("nan", "inf", "-inf", "1e308", "-1e308", "9" * 309, "9" * 5000, "", "x", "\u0661", "1_0")


@pytest.mark.parametrize("field", ["motion", "boot", "program", "step", "gripper", "opening", "q", "v", "t"])
@pytest.mark.parametrize("value", WILD)
def test_a_state_with_a_number_that_cannot_be_meant_is_none(field, value):
    parts = STATE.encode().split()
    (at,) = (n for n, part in enumerate(parts) if part.startswith(f"{field}="))
    parts[at] = f"{field}={','.join([value, *parts[at].partition('=')[2].split(',')[1:]])}"
    with pytest.raises(Malformed, match="this is not a state"):
        ArmState.decode(" ".join(parts))


@given(st.text(max_size=400), st.text("s =,-.eE0123456789qvtnote_motion", max_size=400))
def test_whatever_a_controller_says_is_a_state_or_named(rubbish, nearly):
    for line in (rubbish, nearly, f"s NO_CTRL {nearly}", f"{STATE.encode()} {nearly}"):
        try:
            found = ArmState.decode(line)
        except Malformed:
            continue
        assert all(map(math.isfinite, (*found.q, *found.v, *found.torque, found.opening)))


@pytest.mark.parametrize("digits", [17, 308, 309, 4300, 4301])
@pytest.mark.parametrize("letter", list(FORMS))
def test_an_integer_of_any_length_is_answered(letter, digits):
    form = FORMS[letter]
    line = f"{letter} {' '.join(['9' * digits] * max(1, form.least))}"
    with pytest.raises(Malformed):
        parse(line)
    with pytest.raises(Malformed):
        program(line)
