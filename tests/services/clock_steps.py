"""How the time of day is set in tests, and that the machine sleeps."""

import pytest

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
each_change = pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
each_step = pytest.mark.parametrize("by", STEPS.values(), ids=STEPS)
