"""The linters' rules reach the rooms that they are for; one glob of pyproject.toml that fits nothing would go unseen."""

import subprocess
import sys

import pytest

from tests.environment import ROOT

GIVEN_A_CLOCK = (
    "robots/kit/drivers/mercury", "robots/kit/drivers", "robots/kit/arms", "robots/kit/vision", "robots/kit/slam",
    "robots", "robots/services", "accounts", "queueing/jobs", "operatorlog", "portal/live", "workers/guard",
    "simulators", "simulators/common", "tests", "tests/unit", "tests/services", "tests/security", "tests/world",
    "tests/drivers", "tests/faults", "tests/e2e",
)  # fmt: skip
FREE = ("robots/kit/drivers/irat/ros/scripts", "tests/packages/shuttle/shuttle_robot", "benchmarks")
ASKS = """\
import datetime
import json, time as t
from datetime import UTC, date
from datetime import datetime as d
from time import monotonic

ANSWERS = (
    d.now(UTC),
    datetime.datetime.utcnow(),
    d.today(),
    date.today(),
)
"""
LINES = [2, 5, 8, 9, 10, 11]


MEASURES = """\
from robots.kit.clock import SYSTEM
from robots.kit.clock import TIMER
from tests.faults.viewer import Watching
from tests.faults.witness import Witness

BEGUN = SYSTEM.monotonic()
NOW = SYSTEM.now()
AWAKE = SYSTEM.awake()
"""


def refused(room: str, text: str = ASKS) -> list[int]:
    """Return the lines of a text in which Ruff refuses a clock, in a file of that room."""
    command = [sys.executable, "-m", "ruff", "check", "--select", "TID251", "--output-format", "concise", "-"]
    told = subprocess.run(
        [*command, "--stdin-filename", str(ROOT / room / "not_there.py")],
        cwd=ROOT, input=text, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert not told.stderr, told.stderr
    return [int(line.split(":")[1]) for line in told.stdout.splitlines() if "TID251" in line]


@pytest.mark.parametrize("room", GIVEN_A_CLOCK)
def test_whoever_is_given_a_clock_asks_no_other(room):
    assert refused(room) == LINES


@pytest.mark.parametrize("room", FREE)
def test_elsewhere_the_clock_may_be_asked(room):
    assert refused(room) == []


@pytest.mark.parametrize("room", ["tests/unit", "tests/faults", "tests/e2e"])
def test_a_test_asks_no_clock_of_the_machine_and_nothing_that_measures(room):
    assert refused(room, MEASURES) == [2, 3, 4, 6, 8]
