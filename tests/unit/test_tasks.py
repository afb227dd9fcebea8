"""The language of tasks: what is written is read again, and what is read is bounded."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.arms.tasks import steps
from robots.kit.arms.tasks.parsing import DEEPEST, LONGEST_TEXT, MOST_LINES, MOST_STEPS, BadTask, count, parse
from robots.kit.arms.tasks.steps import Repeat, Step, Task, write

NAMES = st.sampled_from(("a", "red", "brick-1", "x9", "on-top", "table"))
MM = st.integers(-3_000_000, 3_000_000).map(lambda n: n / 1000)
STUDS = st.integers(1, 99)
DEGREES = st.integers(-360_000, 360_000).map(lambda n: n / 1000)
ACTIONS = st.one_of(
    st.builds(steps.Grasp, NAMES),
    st.builds(steps.PutOn, NAMES, NAMES, st.none() | st.tuples(MM, MM), st.none() | DEGREES),
    st.builds(
        steps.PutOn, NAMES, st.just("plate"), st.none(), st.none() | DEGREES, st.tuples(STUDS, STUDS)
    ),
    st.builds(steps.PutAt, NAMES, st.tuples(MM, MM), st.none() | DEGREES),
    st.builds(steps.MoveTo, st.tuples(MM, MM, MM), st.none() | st.tuples(DEGREES, DEGREES, DEGREES)),
    st.builds(steps.MovePosture, NAMES),
    st.builds(steps.Open), st.builds(steps.Close),
    st.builds(steps.Wait, st.integers(0, 30_000).map(lambda n: n / 1000)),
    st.builds(steps.ExpectOn, NAMES, NAMES),
    st.builds(steps.ExpectHeld, st.none() | NAMES),
)  # fmt: skip
BODIES = st.recursive(
    st.lists(st.builds(Step, ACTIONS), min_size=1, max_size=4).map(tuple),
    lambda inner: st.tuples(st.builds(Step, ACTIONS), st.builds(Repeat, st.integers(1, 3), inner)),
    max_leaves=3,
)
WORDS = (
    "grasp",
    "put",
    "move",
    "repeat",
    "end",
    "expect",
    "on",
    "at",
    "by",
    "turned",
    "wait",
    "red",
    "1",
    "-2.5",
    "#",
    "1e9",
)
TEXTS = st.lists(st.lists(st.sampled_from(WORDS), max_size=6).map(" ".join), max_size=12).map("\n".join)


@given(BODIES.filter(lambda body: count(body) <= MOST_STEPS))
def test_what_is_written_is_read_as_the_same_task(body):
    task = Task(body)
    assert parse(write(task)) == task
    assert write(parse(write(task))) == write(task)


@given(st.text(max_size=300) | TEXTS)
def test_any_text_is_a_bounded_task_or_refused_with_a_sentence(text):
    try:
        task = parse(text)
    except BadTask as error:
        assert str(error).endswith(".")
        assert len(str(error)) < 200
        return
    expanded = list(task.steps())
    assert 0 < len(expanded) == count(task.body) <= MOST_STEPS
    assert parse(write(task)) == task


def test_comments_and_empty_lines_count_as_lines_and_nothing_else():
    task = parse("# a tower\n\ngrasp red   # the first\n\tput red on yellow\r\n")
    assert [(one.line, one.action) for one in task.steps()] == [
        (3, steps.Grasp("red")), (4, steps.PutOn("red", "yellow")),
    ]  # fmt: skip
    assert task.lines == 5


def test_repetitions_are_expanded_in_order_and_keep_their_lines():
    task = parse("repeat 2\n wait 1\n repeat 2\n  open\n end\nend\nclose")
    assert [one.line for one in task.steps()] == [2, 4, 4, 2, 4, 4, 7]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "The task has no step."),
        ("# nothing", "The task has no step."),
        (
            "open\nlift red",
            "Line 2: 'lift' is no step; allowed: grasp, put, move, open, close, wait, repeat, end, expect.",
        ),
        ("grasp", "Line 1: allowed: grasp A."),
        (
            "put red beside blue",
            "Line 1: allowed: put A on B [by DX DY] [turned DEG] | put A on plate at COLUMN ROW [turned DEG] | "
            "put A at X Y [YAW].",
        ),
        ("put red at 1", "Line 1: allowed: put A on B"),
        ("put red on yellow at 1 2", "Line 1: allowed: put A on B"),
        ("put red on plate at 1", "Line 1: allowed: put A on B"),
        ("put red on plate at 0 2", "Line 1: '0' must be a whole number from 1 to 99, a column or row of studs."),
        ("put red on plate at 1 2.5", "Line 1: '2.5' must be a whole number"),
        ("put red at x 2", "Line 1: 'x' must be a number from -3000 to 3000."),
        ("put red at nan 2", "Line 1: 'nan' must be a number"),
        ("put red at 1e9 2", "Line 1: '1e9' must be a number"),
        ("move 1 2", "Line 1: allowed: move X Y Z [ROLL PITCH YAW] | move POSTURE."),
        ("wait -1", "Line 1: '-1' must be a number from 0 to 30."),
        ("wait 31", "from 0 to 30"),
        ("expect red", "Line 1: allowed: expect A on B | expect holding A | expect empty."),
        ("repeat 2\nopen", "Line 1: this repeat has no end."),
        ("open\nend", "Line 2: end ends a repeat; there is none."),
        ("repeat 0\nopen\nend", "Line 1: repeat needs a whole number from 1 to 100, not '0'."),
        ("repeat 2\nend", "Line 2: nothing stands between repeat and end."),
        ("grasp <b>", "Line 1: '<b>' is no name"),
        ("repeat 100\nopen\nopen\nopen\nend", "The task has 300 steps with its repetitions; at most 200 are possible."),
        ("\n".join(["repeat 100"] * 4 + ["open"] + ["end"] * 4), "The task has 100000000 steps"),
        ("\n".join(["repeat 1"] * (DEEPEST + 1)), f"repetitions stand at most {DEEPEST} deep in each other"),
        ("open\n" * MOST_LINES, f"at most {MOST_LINES} lines"),
        ("#" * (LONGEST_TEXT + 1), f"at most {LONGEST_TEXT} characters"),
        ("#" + "x" * 120 + "\n" + "open " + " " * 120, "Line 2: a line has at most 120 characters."),
    ],
)
def test_what_is_no_task_is_refused_with_its_line_and_what_is_allowed(text, says):
    with pytest.raises(BadTask) as error:
        parse(text)
    assert says in str(error.value)
