"""How the time of day is set in tests, and that the machine sleeps."""

from datetime import timedelta

import pytest

from queueing import services as queue
from queueing.models import Turn
from robots.models import Lease

HOUR, YEAR = 3600.0, 365.25 * 86_400
STEPS = {
    "an hour ahead": HOUR,
    "an hour back": -HOUR,
    "20 s back": -20.0,
    "from 1970": 56 * YEAR,
    "from 2100": -74 * YEAR,
}
SET = {name: lambda clock, by=by: clock.step(by) for name, by in STEPS.items()}
CHANGES = SET | {"the machine slept": lambda clock: clock.suspend(2 * HOUR)}
ON_BOTH = (
    "from 1970",
    "20 s back",
    "the machine slept",
)  # the statements are alike for all: of each database these are asked


def _each(name, values):
    marks = {one: [pytest.mark.service] if one in ON_BOTH else [] for one in values}
    return pytest.mark.parametrize(name, [pytest.param(told, id=one, marks=marks[one]) for one, told in values.items()])


each_change = _each("change", CHANGES)
each_step = _each("by", STEPS)


def drive(robot, people, clock):
    """Let Ada join, be offered the robot and accept; return her turn."""
    queue.join(robot, people["ada"], clock.now())
    Lease.objects.update(expires_at=clock.now() + timedelta(seconds=2))
    queue.tick(clock.now())
    queue.accept(robot, people["ada"], clock.now())
    return Turn.objects.get()
