"""The rover's missions: what is read and written, what is refused, and how long a mission takes."""

from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.contract.errors import BadRequest, OutOfWorkspace
from robots.kit.drivers.srv1.hall import hall
from robots.kit.drivers.srv1.missions import LONGEST, MOST_STEPS, Step, judge, legs, parse, refuse, write

HOME = hall().home
NODES = st.sampled_from(hall().nodes).map(lambda node: Step("go", node.at, node.name))
STEPS = st.one_of(
    NODES,
    st.tuples(st.integers(0, 12_000), st.integers(0, 8_000)).map(lambda at: Step("go", (at[0] / 1000, at[1] / 1000))),
    st.integers(-360, 360).map(lambda angle: Step("turn", (angle * pi / 180,))),
    st.sampled_from([Step("look"), Step("photograph"), Step("read")]),
    st.integers(0, 120).map(lambda s: Step("wait", (float(s),))),
    st.integers(1, 120).map(lambda s: Step("patrol", (float(s),))),
    st.text(st.characters(min_codepoint=33, max_codepoint=0x2FF), min_size=1, max_size=80)
    .filter(str.isprintable).filter(lambda words: words == words.strip())
    .map(lambda words: Step("say", (), words)),
)  # fmt: skip


@given(st.lists(STEPS, min_size=1, max_size=MOST_STEPS))
def test_what_is_written_is_read_again(steps):
    """A mission survives its text."""
    text = write(steps)
    if len(text) <= LONGEST:
        again = parse(text)
        assert [(s.verb, s.words) for s in again] == [(s.verb, s.words) for s in steps]
        for one, other in zip(again, steps, strict=True):
            assert one.numbers == pytest.approx(other.numbers, abs=1e-3)


@given(st.text(max_size=300))
def test_any_text_is_a_mission_or_refused_with_a_sentence(text):
    """Nothing else is raised, and the sentence names the line."""
    try:
        assert parse(text)
    except BadRequest as error:
        assert str(error).endswith(".")
        assert "Line" in str(error) or "A mission has" in str(error)


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("go", "go where"), ("go nowhere", "go where"), ("go 1e308 1", "left wall"), ("go nan 1", "left wall"),
        ("go 1 nan1", "lower wall"), ("go -1 3", "left wall"), ("turn", "angle"), ("turn 361", "angle"),
        ("turn inf", "angle"), ("wait 121", "a time"), ("wait -1", "a time"), ("patrol 0", "a time"),
        ("look up", "no step"), ("photograph it", "no step"), ("say", "say what"), ("dance", "no step"),
        ("say " + "a" * 200, "characters"),
    ],
)  # fmt: skip
def test_a_bad_line_is_refused_by_its_number(line, says):
    """The number of the line, and what is wrong with it."""
    with pytest.raises(BadRequest, match=f"Line 3: .*{says}"):
        parse(f"# a mission\nread\n{line}\n")


def test_too_much_is_refused_before_it_is_read():
    """Characters, steps, and a mission without any."""
    for text in ("read\n" * (MOST_STEPS + 1), "#" * (LONGEST + 1), "", "# only words\n"):
        with pytest.raises(BadRequest, match="A mission has"):
            parse(text)


def test_a_step_that_cannot_be_done_is_named():
    """A place inside of a showcase, in the third step."""
    steps = parse("go South\nread\ngo 3.0 2.6\n")
    with pytest.raises(OutOfWorkspace, match=r"^Step 3, go 3 2.6: The rover cannot stand there"):
        list(legs(steps, HOME))


@given(st.lists(NODES | st.just(Step("look")) | st.just(Step("turn", (pi / 2,))), min_size=1, max_size=12))
def test_each_leg_begins_where_the_last_one_ended_and_takes_no_less_than_the_least(steps):
    """The poses of a mission are one path; its usual time is above its least."""
    here = HOME
    for number, leg in enumerate(legs(steps, HOME), 1):
        assert leg.step == number
        assert leg.poses[0] == here
        assert 0.0 <= leg.least_s <= leg.seconds
        here = leg.poses[-1]
    gone = [step for step in steps if step.verb == "go"]
    if gone:
        assert here[:2] == gone[-1].numbers


def test_a_mission_that_cannot_end_in_its_limit_is_refused_by_its_step():
    """Eight waits of two minutes are more than a quarter of an hour; seven may be late after a long way."""
    steps = parse("wait 120\n" * 8)
    found, said = judge(steps, HOME)
    assert len(found) == 7
    assert [(one.step, one.refuses) for one in said] == [(8, True)]
    with pytest.raises(OutOfWorkspace, match=r"^Will not run, after 16:00 min: Step 8 cannot be done in time"):
        refuse(said)
    refuse(judge(steps[:7], HOME)[1])
    long = parse("wait 120\n" * 7 + "go East\ngo Door\n")
    assert [(one.step, one.refuses) for one in judge(long, HOME)[1]] == [(9, False)]


def test_what_is_to_say_of_a_mission_names_step_and_time():
    """A way after a patrol is a guess, which is a warning; a place in a showcase ends the judgement."""
    steps = parse("wait 5\npatrol 30\nread\ngo South\ngo Door\ngo 3.0 2.6\nread\n")
    found, said = judge(steps, HOME)
    assert len(found) == 5
    assert [(one.step, one.refuses) for one in said] == [(4, False), (6, True)]
    assert said[0].at_s == pytest.approx(35.0)
    assert said[1].at_s == pytest.approx(sum(leg.seconds for leg in found))
    minutes, seconds = divmod(round(said[1].at_s), 60)
    assert minutes >= 1
    with pytest.raises(OutOfWorkspace, match=rf"^Will not run, after {minutes}:{seconds:02d} min: Step 6, go 3 2.6: "):
        refuse(said)


@given(st.lists(STEPS, min_size=1, max_size=12))
def test_any_mission_is_judged_and_what_is_refused_says_why(steps):
    """A refusal is the last judgement, and times do not fall."""
    found, said = judge(steps, HOME)
    assert (len(found) == len(steps)) == (not any(one.refuses for one in said))
    assert all(not one.refuses for one in said[:-1])
    assert [one.at_s for one in said] == sorted(one.at_s for one in said)
