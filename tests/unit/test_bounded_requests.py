"""Any request to a robot's check, preview or program checker costs little work and is answered in words."""

import contextlib
import gc
import math
import re
import tracemalloc
from functools import partial

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robots.kit.arms.described import posture
from robots.kit.arms.planner import Refused
from robots.kit.contract import find, values
from robots.kit.contract.capabilities import Preview
from robots.kit.contract.errors import BadRequest, OutOfWorkspace, RobotError
from robots.kit.description import load
from robots.kit.drivers.pa10.courses import Courses
from robots.kit.drivers.pa10.protocol import Malformed, program
from tests.conftest import at_length

CPU_S, MEMORY = 0.2, 50e6
YARDS = 4.5  # as many cost 0.2 s where the limit was set; a slower machine is allowed the same work
DRIVERS = ("mercury", "pa10", "so101", "irat", "srv1")
HUGE = (10**5000, -(10**5000), 1e308, -1e308, 1e4, 1e22, -1e4, 5e-324, math.nan, math.inf, -math.inf)
HUGE_IDS = ["ten to the 5000", "minus that", *map(str, HUGE[2:])]
READY = tuple(posture(load("pa10"), "ready"))
NUMBERS = [pytest.param(60, id="some"), at_length(2000)]

reals = st.one_of(
    st.floats(),
    st.integers(-(10**400), 10**400),
    st.integers(0, len(HUGE) - 1).map(lambda i: HUGE[i]),
    st.floats(-3, 3),
)
leaves = st.one_of(
    st.none(), st.booleans(), reals, st.text(max_size=20), st.sampled_from(["9" * 5000, "²", "\ud800\0", "x" * 10**6])
)
wild = st.recursive(leaves, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4), max_leaves=12)  # fmt: skip
deep = st.integers(1, 3000).map(lambda depth: nested(depth))
numerals = st.one_of(
    reals.map(lambda v: repr(v) if isinstance(v, float) else str(v % 10**400)), st.integers(-400, 400).map(str),
    st.floats(0, 700).map(lambda v: f"{v:.2f}"), st.sampled_from(["1e308", "nan", "-inf", "²", "9" * 150, "1_0", ""]),
)  # fmt: skip
lines = st.tuples(st.sampled_from("jkKlgdREpsuhJC#x"), st.lists(numerals, max_size=8)).map(
    lambda pair: " ".join([pair[0], *pair[1]])
)
texts = st.lists(lines, max_size=60).map("\n".join)


@pytest.fixture(scope="module", autouse=True)
def loaded():
    """Libraries are loaded once a process, at their first use; that is not what is measured."""
    args = {**SIX, "x": 0.5, "z": 0.3}
    for kind in ("line", "pose"):
        with contextlib.suppress(RobotError):
            check("pa10", kind, args)
        with contextlib.suppress(RobotError):
            preview(kind, args, READY)
    for name in DRIVERS:
        with contextlib.suppress(RobotError):
            check(name, "move", {"x": 0.0, "y": 0.4})


def nested(depth):
    found = []
    for _ in range(depth):
        found = [found]
    return found


def check(name, kind, args):
    values.check(name, kind, args, {})


def preview(kind, args, joints, name="pa10"):
    return find.function(find.spec_of(name).capability(Preview).function)(kind, args, joints, {})


def answer(call, allowed):
    """Call; return what was raised."""
    try:
        call()
    except allowed as error:
        assert len(str(error)) < 1000, "an answer that nobody reads"
        return error
    return None


def memory(call, allowed):
    """Call; hold the memory that it takes against its limit. Return what was raised."""
    tracemalloc.start()
    try:
        raised = answer(call, allowed)
        assert tracemalloc.get_traced_memory()[1] < MEMORY
    finally:
        tracemalloc.stop()
    return raised


def processor_time(stopwatch, call, allowed):
    """Call; hold the time of the processor against its limit. Return what was raised.

    What else runs makes a call take longer, never less: one that took too long is measured twice more.
    """
    least = math.inf
    for _ in range(3):
        begun = stopwatch.process_time()
        raised = answer(call, allowed)
        least = min(least, stopwatch.process_time() - begun)
        if least < CPU_S:
            return raised
    assert least < YARDS * yard_s(stopwatch)
    return raised


@pytest.fixture(params=["memory", pytest.param("processor_time", marks=pytest.mark.timed)])
def measured(request):
    """What is held against its limit while something is called."""
    return memory if request.param == "memory" else partial(processor_time, request.getfixturevalue("stopwatch"))


def yard_s(stopwatch):
    """Return what a fixed piece of work costs on this machine now (s): a slow or busy one takes longer for everything."""
    begun = stopwatch.process_time()
    sum(i * i for i in range(10**6))
    return stopwatch.process_time() - begun


def refused_or_done(measured, name, kind, args, joints):
    measured(lambda: check(name, kind, args), RobotError)
    if find.spec_of(name).capability(Preview) is not None:
        measured(lambda: preview(kind, args, joints, name), RobotError)


@pytest.fixture(scope="module", autouse=True)
def _warm():
    """Do what is no request's work: make what a process makes once, and collect what other tests left behind."""
    for name in ("mercury", "pa10"):
        check(name, "noop", {})
    preview("home", {}, READY)
    preview("line", {"x": 0.5, "y": 0.1, "z": 0.3, "roll": math.pi, "pitch": 0, "yaw": math.pi}, READY)
    with contextlib.suppress(RobotError):
        check("pa10", "program", {"text": "j 0 0 0 0 0 0\nl 500 0 300 180 0 180"})
    gc.collect()
    yield
    gc.unfreeze()


@pytest.fixture(autouse=True)
def _only_its_own(_warm):
    """Thousands of examples leave much behind; a look through it falls into whatever runs then."""
    gc.freeze()


@pytest.mark.asvs("2.4.1", "15.2.2")
@pytest.mark.parametrize("examples", NUMBERS)
@pytest.mark.parametrize("name", DRIVERS)
def test_no_values_at_all_take_long_or_raise_anything_but_our_own_errors(measured, name, examples):
    commands = find.spec_of(name).commands

    @settings(max_examples=examples, deadline=None, suppress_health_check=list(HealthCheck))
    @given(st.data())
    def go(data):
        command = data.draw(st.sampled_from(commands))
        names = [a.name for a in command.arguments]
        values = {n: data.draw(st.one_of(wild, deep, reals, st.floats(-1.5, 1.5))) for n in names}
        args = data.draw(st.one_of(st.just(values), wild, st.just({**values, "more": 1})))
        kind = data.draw(st.one_of(st.just(command.kind), st.just(command.kind), wild))
        joints = data.draw(st.one_of(st.just(READY), st.lists(reals, max_size=20).map(tuple), wild))
        refused_or_done(measured, name, kind, args, joints)

    go()


@pytest.mark.asvs("2.4.1", "15.2.2")
@pytest.mark.parametrize("examples", NUMBERS)
def test_no_program_takes_long_to_look_through(measured, examples):
    courses = Courses()

    @settings(max_examples=examples, deadline=None, suppress_health_check=list(HealthCheck))
    @given(texts)
    def go(text):
        refused_or_done(measured, "pa10", "program", {"text": text}, READY)
        measured(lambda: courses.check(program(text), np.array(READY)), (Malformed, Refused))

    assert preview("program", {"text": "d 1"}, READY).seconds == 1
    go()


def spread(letter, count, low, high, tail="", seed=1):
    """Return a program of so many different motions."""
    dice = np.random.default_rng(seed)
    rows = dice.uniform(low, high, (count, len(low)))
    return "\n".join(f"{letter} {' '.join(f'{v:.0f}' for v in row)}{tail}" for row in rows)


LINES_ALL_ROUND = "\n".join(f"l {x} {y} 300 180 0 180" for _ in range(40) for x, y in ((500, -300), (500, 300)))
JUST_ABOVE = "\n".join(f"l 500 {y} 18 180 0 {180 - n / 10}" for n in range(60) for y in (-300, 300))
PROGRAMS = {
    "different joints": spread("j", 200, (-60, -10, 30, -60, 30, -60), (60, 30, 80, 60, 90, 60)),
    "different places": spread("k", 200, (400, -250, 150), (600, 250, 400), " 180 0 180"),
    "slow places": spread("k", 200, (400, -250, 150), (600, 250, 400), " 180 0 180 0.05"),
    "different lines": spread("l", 200, (400, -250, 150), (600, 250, 400), " 180 0 180"),
    "lines to and fro": LINES_ALL_ROUND,
    "along the table": f"k 500 0 18 180 0 180\n{JUST_ABOVE}",
    "turning where the wrist is straight": "j 0 25 75 0 0 0\n" + "\n".join(f"j 0 25 75 {n} 0 {-n}" for n in range(90)),
    "repeated": "R 100\nR 100\nj 10 20 60 0 50 0\nj 20 20 60 0 50 0\nE\nE",
    "repeated within the limit": "R 100\nj 10 20 60 0 50 0\nj 20 20 60 0 50 0\nE",
    "repetitions of nothing": "R 100\n" * 500 + "E\n" * 500,
    "waits": "d 30\n" * 400,
    "far away": "l 1e8 0 0 0 0 0",
    "as far as numbers go": "l 1e308 1e308 1e308 1e308 1e308 1e308\nj 1e308 0 0 0 0 0",
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_programs_made_to_be_slow(measured, name):
    text = PROGRAMS[name]
    refused_or_done(measured, "pa10", "program", {"text": text[:6000].rpartition("\n")[0] or text}, READY)
    courses = Courses()
    measured(lambda: courses.check(program(text), np.array(READY)), (Malformed, Refused))


TASKS = {
    "different places": "\n".join(f"put red at {400 + 13 * (n % 19)} {200 + 9 * (n % 17)} {n}" for n in range(150)),
    "all round": "\n".join(f"move {500 - n} {y} 300" for n in range(80) for y in (-300, 300)),
    "turning": "\n".join(f"move 500 0 300 180 0 {n}" for n in range(150)),
    "to and fro": "repeat 100\nmove home\nmove ready\nend",
    "towers": "repeat 20\nput red on yellow\nput blue on red\nput green on blue\nput green at 600 -180\nput blue at 500 -80\n"
    "put red at 500 160\nend",
    "over a tower": "put blue on yellow\nput green on blue\n" + "\n".join(
        f"put red at {500 + n} {y}" for n in range(40) for y in (200, -100)
    ),
    "repetitions of nothing": "repeat 100\n" * 90 + "end\n" * 90,
    "waits": "wait 30\n" * 199,
    "expectations": "expect red on table\n" * 199,
    "long numbers": "move " + "9" * 100,
}  # fmt: skip


@pytest.mark.parametrize("name", TASKS)
def test_tasks_made_to_be_slow(measured, name):
    refused_or_done(measured, "pa10", "task", {"text": TASKS[name]}, READY)


SIX = dict.fromkeys(("x", "y", "z", "roll", "pitch", "yaw"), 0.0)


@pytest.mark.parametrize("value", HUGE, ids=HUGE_IDS)
@pytest.mark.parametrize("axis", ["x", "roll", "speed"])
@pytest.mark.parametrize("kind", ["line", "pose"])
def test_a_place_beyond_all_bounds_is_refused_with_the_bound(measured, kind, axis, value):
    args = {**SIX, "x": 0.5, "z": 0.3, axis: value}
    for call in (lambda: check("pa10", kind, args), lambda: preview(kind, args, READY)):
        error = measured(call, (BadRequest, OutOfWorkspace))
        if isinstance(value, float) and math.isfinite(value) and abs(value) > 1:
            assert isinstance(error, BadRequest)
            assert f"{axis} must lie between" in str(error)


@pytest.mark.parametrize("value", HUGE, ids=HUGE_IDS)
def test_mercury_names_its_bound_for_a_place_far_away(measured, value):
    error = measured(lambda: check("mercury", "move", {"x": value, "y": 0.4}), (BadRequest, OutOfWorkspace))
    if isinstance(value, float) and abs(value) > 10:
        assert "the arm reaches" in str(error) or "finite" in str(error)
    assert error is None or len(str(error)) < 200


def test_a_line_from_one_end_of_the_reach_to_the_other_is_looked_at_in_time(measured):
    args = {"x": 0.5, "y": 0.4, "z": 0.3, "roll": math.pi, "pitch": 0.0, "yaw": math.pi}
    low = (*np.radians([-40.0, 25, 75, 0, 80, 0]),)
    assert measured(lambda: preview("line", args, low), RobotError) is None
    slow = measured(lambda: preview("joints", {**dict.fromkeys(("S2", "E1", "E2", "W1", "W2"), 0.2), "S1": 2.9, "speed": 0.05}, READY), RobotError)  # fmt: skip
    assert "longer than the 30 s" in str(slow)


def test_a_program_that_lasts_too_long_is_refused_with_the_bound():
    text = "\n".join(["d 30"] * 11)
    (said,) = preview("program", {"text": text}, READY).judgements
    assert (said.step, said.at_s, said.refuses) == (11, 300.0, True)
    assert "the program would take longer than the 300 s" in said.text
    with pytest.raises(Refused, match=r"step 11, after 300.0 s: .* 300 s"):
        Courses().check(program(text), np.array(READY))
    moves = "R 60\nj 90 0 60 0 60 0\nj -90 0 60 0 60 0\nE"
    (said,) = preview("program", {"text": moves}, READY).judgements
    assert re.match(r"Step \d+: the program would take longer than the 300 s", said.text)
    assert 290.0 < said.at_s <= 300.0, "the time at which that step would begin"


def test_a_program_that_is_too_much_to_plan_is_refused_with_the_bound():
    with pytest.raises(Refused, match=r"step \d+, after [\d.]+ s: .* about 10 m of straight lines"):
        Courses().check(program(PROGRAMS["different lines"]), np.array(READY))


@pytest.mark.parametrize("kind", ["gripper", "noop", "jog_joints", "jog_tool"])
def test_what_leads_nowhere_has_no_preview(kind):
    with pytest.raises(BadRequest, match="no path to show"):
        preview(kind, {"closed": 1} if kind == "gripper" else {}, READY)
