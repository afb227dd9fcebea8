"""The control application between its two threads."""

import numpy as np
import pytest

from robots.description import load, posture
from robots.drivers.pa10.courses import Courses
from robots.drivers.pa10.protocol import parse
from robots.motion.planner import Refused
from simulators.pa10.application import Application
from simulators.pa10.store import ProgramStore

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


def test_what_was_asked_before_a_hold_does_not_begin_after_it(app):
    asked = app.asked
    app.hold()
    with pytest.raises(Refused, match="a hold came before it could begin"):
        app.take(parse("j 30 25 75 0 80 0"), asked)
    assert not app.moving
    assert app.take(parse("j 30 25 75 0 80 0"), app.asked).startswith("ok")
