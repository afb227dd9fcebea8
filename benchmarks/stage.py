"""The stage of a benchmark: the tests' stores and processes, and one JSON line at the end."""

import contextlib
import json
import os
import statistics
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any


def set_up(database: str = "sqlite") -> None:
    """Choose the database and make Django ready; once a process."""
    os.environ["FARHAND_TEST_DB"] = database
    import tests.environment  # noqa: F401

    os.environ.setdefault("DJANGO_SETTINGS_MODULE", "portal.settings")
    import django

    django.setup()


def again(database: str) -> dict[str, Any]:
    """Run this benchmark in a process of its own on another database; return its last line."""
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks", *sys.argv[1:]], env={**os.environ, "FARHAND_BENCH_DB": database},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    lines = done.stdout.strip().splitlines()
    print(*(f"[{database}] {line}" for line in lines[:-1]), sep="\n")
    found: dict[str, Any] = json.loads(lines[-1])
    return found


@contextlib.contextmanager
def database() -> Iterator[None]:
    """A migrated test database that child processes see."""
    from django.db import connection
    from django.test.utils import setup_databases, teardown_databases

    config = setup_databases(0, interactive=False)
    try:
        yield
    finally:
        connection.close()
        with contextlib.suppress(Exception):
            teardown_databases(config, 0)
        for leftover in Path(os.environ["FARHAND_VAR"]).glob("test.sqlite3*"):  # a log of the last would spoil the next
            leftover.unlink()


def cast() -> tuple[Any, Any]:
    """Return a robot and a cleared person."""
    from accounts.models import Clearance, User
    from queueing.services import queue_of
    from robots.kit.clock import SYSTEM
    from robots.models import Robot
    from tests.conftest import CALIBRATION

    robot = Robot.objects.create(
        slug="mercury", name="Mercury", driver="mercury", address="sim:mercury", enabled=True, calibration=CALIBRATION
    )
    queue_of(robot)
    person = User.objects.create_user("ada", "ada@example.org", "correct horse 42")
    Clearance.objects.create(user=person, robot=robot, granted_at=SYSTEM.now())
    return robot, person


def percentile(values: list[float], share: float) -> float:
    """Return the value that `share` of all lie below."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def tell(name: str, value: float, unit: str, goal: str, holds: bool, beside: dict[str, Any]) -> None:
    """Print the last line."""
    print(
        json.dumps(
            {"name": name, "value": round(value, 3), "unit": unit, "goal": goal, "holds": holds, "beside": beside}
        )
    )


median = statistics.median
