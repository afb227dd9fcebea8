"""A program of the museum arm tells which of its steps it is at."""

import pytest

from robots.kit.contract.session import Progress
from tests.drivers.pa10_wire import allow

pytestmark = pytest.mark.timed


def test_a_program_tells_its_steps(arm, shared):
    told = []
    arm.execute("program", {"text": "# m\u00e9chant\u2028g 1\x0b\nR 2\nd 4 # s\nE"}, allow, told.append)
    assert told[:2] == ["sent", "acknowledged"]
    steps = list(dict.fromkeys(told[2:]))
    assert steps == [Progress("step 1 of 2", 0.0), Progress("step 2 of 2", 0.5)]
