"""The control application between its two threads."""

import threading

import numpy as np
import pytest

from robots.kit.arms.described import posture
from robots.kit.arms.planner import Refused
from robots.kit.description import load
from robots.kit.drivers.pa10.courses import Courses
from robots.kit.drivers.pa10.protocol import End, Mode, parse
from simulators.pa10.application import Application
from simulators.pa10.scene import STEP_S
from simulators.pa10.store import ProgramStore
from tests.waiting import CEILING_S

STILL = np.zeros(6)


@pytest.fixture
def courses():
    return Courses()


@pytest.fixture
def app(courses, tmp_path):
    return Application(
        courses, posture(load("pa10"), "ready"), lambda *_, **__: None, ProgramStore(tmp_path / "programs.json")
    )


@pytest.mark.parametrize(("line", "moving"), [("j 0 25 75 0 80 0", True), ("j 0 25 75 0 80 0", False), ("p 1", False)])
def test_a_hold_while_something_is_planned_is_the_last_word(monkeypatch, courses, app, line, moving):
    q = posture(load("pa10"), "ready")
    if moving:
        for first in ("j 30 25 75 0 80 0", "j -20 20 75 0 80 0"):
            assert app.take(parse(first)).startswith("ok")
            for _ in range(150):
                q = app.step(q, STILL).q
    slow = {"j": "plan", "p": "check"}[line[0]]
    planned = getattr(courses, slow)

    def held_meanwhile(*args):
        found = planned(*args)
        app.hold()
        return found

    monkeypatch.setattr(courses, slow, held_meanwhile)
    with pytest.raises(Refused, match="a hold came before it could begin"):
        app.take(parse(line))
    for _ in range(500):
        q = app.step(q, STILL).q
    rest = q.copy()
    for _ in range(1500):
        q = app.step(q, STILL).q
    assert not app.moving
    assert q == pytest.approx(rest)


def test_a_range_error_outlives_a_restart(courses, app, tmp_path):
    """The application begins with it: at power-on outside a range, and when its watchdog restarts it."""
    noted = []
    q = posture(load("pa10"), "ready")
    again = Application(
        courses, q, lambda event, **about: noted.append(event), ProgramStore(tmp_path / "programs.json"),
        error="joint S1 would be at 180.0\u00b0",
    )  # fmt: skip
    assert (again.letter(), again.mode, again.end) == ("e", Mode.RANGE_ERROR, End.RANGE)
    assert (again.error, noted) == ("joint S1 would be at 180.0 deg", ["range_error"])
    again.step(q, STILL)
    again.hold()
    assert again.letter() == "e"
    assert again.take(parse("j 0 0 0 0 0 0")).startswith("ok")
    for _ in range(20_000):
        again.step(q, STILL)
    assert again.letter() == "a"


def test_what_was_asked_before_a_hold_does_not_begin_after_it(app):
    asked = app.hold_count
    app.hold()
    with pytest.raises(Refused, match="a hold came before it could begin"):
        app.take(parse("j 30 25 75 0 80 0"), asked)
    assert not app.moving
    assert app.take(parse("j 30 25 75 0 80 0"), app.hold_count).startswith("ok")


def moved_while_planning(monkeypatch, courses, app, line, seconds):
    """Begin a motion, then give a target whose planning takes so many seconds of the control loop, one for each try."""
    q = posture(load("pa10"), "ready")
    assert app.take(parse("j 60 25 75 0 80 0 0.1")).startswith("ok")
    for _ in range(100):
        q = app.step(q, STILL).q
    planned, left, begun = courses.plan, list(seconds), []

    def slow(*args):
        nonlocal q
        found = planned(*args)
        begun.append(q)
        for _ in range(round(left.pop(0) / STEP_S)):
            q = app.step(q, STILL).q
        return found

    monkeypatch.setattr(courses, "plan", slow)
    return app.take(parse(line)), len(begun)


def test_the_controller_looks_ahead_by_what_planning_takes(monkeypatch, courses, app):
    """A machine under load plans in a third of a second: the second try reckons with it, and so does the next target."""
    said, tries = moved_while_planning(monkeypatch, courses, app, "j 30 20 75 0 80 0", [0.3] * 2)
    assert (said, tries) == ("ok 2", 2)


def test_a_target_that_comes_too_late_is_refused_for_that_reason(monkeypatch, courses, app):
    with pytest.raises(Refused, match=r"planning took 1500 ms and the arm had gone on by then, 4 times"):
        moved_while_planning(monkeypatch, courses, app, "j 30 20 75 0 80 0", [1.5] * 4)


def test_a_target_that_others_overtake_is_refused_for_that_reason(monkeypatch, courses, app):
    planned, others = courses.plan, iter(("j 20 20 75 0 80 0", "j 10 20 75 0 80 0") * 2)
    q = posture(load("pa10"), "ready")

    def overtaken(request, *args):
        found = planned(request, *args)
        with monkeypatch.context() as patch:
            patch.setattr(courses, "plan", planned)
            app.take(parse(next(others)))
        for _ in range(50):
            app.step(q, STILL)
        return found

    monkeypatch.setattr(courses, "plan", overtaken)
    with pytest.raises(Refused, match="another motion began while this one was planned, 4 times"):
        app.take(parse("j 30 20 75 0 80 0"))


def test_nobody_reads_the_hold_of_a_range_error_without_the_error(monkeypatch, app):
    assert app.take(parse("j 30 25 75 0 80 0")).startswith("ok")
    said, asking = [], threading.Thread(target=lambda: said.append((app.letter(), app.end)))

    def note(event, **_):
        if event == "end":  # the motion is held, and the error still to be told
            asking.start()
            asking.join(0.1)

    monkeypatch.setattr(app, "_note", note)
    out = posture(load("pa10"), "ready") + np.array([0.0, 0.0, 0.0, 0.0, 0.0, 9.0])
    app.step(out, STILL)
    asking.join(CEILING_S)
    assert said == [("e", End.RANGE)]
