"""The control application between its two threads."""

import numpy as np
import pytest

from robots.description import load, posture
from robots.drivers.pa10.courses import Courses
from robots.drivers.pa10.protocol import parse
from simulators.pa10.application import Application

STILL = np.zeros(6)


def test_a_hold_while_the_next_target_is_planned_is_no_error(monkeypatch):
    courses = Courses()
    q = posture(load("pa10"), "ready")
    app = Application(courses, q, lambda *_, **__: None, {})
    for line in ("j 30 25 75 0 80 0", "j -20 20 75 0 80 0"):
        assert app.take(parse(line)).startswith("ok")
        for _ in range(150):
            q = app.step(q, STILL).q
    plan, held = courses.plan, []

    def held_meanwhile(*args):
        if not held:
            held.append(app.hold())
        return plan(*args)

    monkeypatch.setattr(courses, "plan", held_meanwhile)
    assert app.take(parse("j 0 25 75 0 80 0")).startswith("ok"), "planned again, from the way on which it brakes"
    for _ in range(3000):
        q = app.step(q, STILL).q
    assert np.degrees(q) == pytest.approx([0, 25, 75, 0, 80, 0], abs=0.01)
