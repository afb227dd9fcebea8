"""Which waiting jobs are no longer good, by what their robot tells meanwhile."""

from datetime import datetime, timedelta

from django.db.models import QuerySet

from queueing.models import Job
from robots.grants import lease_of
from robots.kit.contract.capabilities import GoodWhile
from robots.kit.contract.find import spec_or_none
from robots.models import Robot

FRESH = timedelta(seconds=60)  # an older value of a channel is not used
LATER = timedelta(seconds=2)  # a state must be so much newer than the job: clocks of hosts differ


def outdated(robot: Robot, waiting: QuerySet[Job], now: datetime) -> list[tuple[Job, GoodWhile]]:
    """Return the robot's waiting jobs an argument of which the robot has left behind, and what its spec says of them.

    Nothing is judged by a state that is old, or was told before the job: its asker may have seen a newer one.
    """
    spec = spec_or_none(robot.driver)
    declared = spec.all_of(GoodWhile) if spec else ()
    lease = lease_of(robot) if declared else None
    if lease is None or lease.state_at is None or now - lease.state_at > FRESH:
        return []
    values = lease.state.get("values") or {}
    found: list[tuple[Job, GoodWhile]] = []
    for good in declared:
        told = values.get(good.channel)
        if isinstance(told, int | float):
            asked = waiting.filter(kind=good.kind, asked_at__lt=lease.state_at - LATER)
            found += [(job, good) for job in asked if job.args.get(good.argument, told) != told]
    return found
