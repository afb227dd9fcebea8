"""The open jobs of a robot as its page shows them to everybody: without people, texts and addresses."""

from datetime import datetime
from typing import Any

from queueing.services import Forecast, forecast, job_kinds
from robots.models import Robot

SHOWN = 50


def jobs_shown(robot: Robot, now: datetime) -> list[dict[str, Any]]:
    """Return the open jobs in the order in which they will be served; none if the robot takes no jobs."""
    if not job_kinds(robot):
        return []
    return [job_info(one) for one in forecast(robot, now)[:SHOWN]]


def job_info(one: Forecast) -> dict[str, Any]:
    """Return the fields of an open job that everybody may see; of its values the numbers."""
    job = one.job
    return {
        "id": job.pk, "kind": job.kind, "state": job.state, "ahead": one.ahead, "wait_s": one.wait_s,
        "args": {name: value for name, value in job.args.items() if isinstance(value, int | float)},
    }  # fmt: skip
