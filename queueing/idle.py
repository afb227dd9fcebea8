"""The robot's own behaviour: its needs before everybody's requests, idle behaviour while nobody asks."""

from datetime import datetime, timedelta
from typing import TypeVar

from queueing.jobs.kinds import label_of, limit_of
from queueing.models import Queue, QueueRobot
from queueing.rows import links_of
from robots import bus
from robots.grants import lease_of, newest_grant_that_moves, start_grant
from robots.kit.contract.capabilities import Idle, Need
from robots.kit.contract.errors import BadRequest
from robots.kit.contract.find import spec_or_none
from robots.models import Grant, Robot
from robots.models.robot import FRESH
from robots.services.commands import over_by, put
from robots.states import CommandState, GrantEnd, GrantKind

AGAIN_S = 30.0  # least time from a need's failed command, or from the begin of a short idle slice, to the next
REFUSED_S = 3600.0  # pause after the robot refused its idle behaviour
NOTED_S = 20.0  # between two notes that somebody watches
C = TypeVar("C")


def wanted_need(robot: Robot, now: datetime) -> Need | None:
    """Return the need that comes before all requests: a channel is too low, or not yet full again."""
    found = _capabilities(robot, Need)
    if not found:
        return None
    lease = lease_of(robot)
    if lease is None or lease.state_at is None or now - lease.state_at > FRESH:
        return None
    values = lease.state.get("values") or {}
    last = newest_grant_that_moves(robot)
    serving = last.commands.values_list("kind", flat=True).first() if last is not None and serves_need(last) else ""
    for need in found:
        value = values.get(need.channel)
        bound = need.until if need.kind == serving else need.below
        if isinstance(value, int | float) and value < bound:
            return need
    return None


def serves_need(grant: Grant) -> bool:
    """Return whether the grant is for a need of the robot itself, and not for a command of staff."""
    return grant.kind == GrantKind.UPKEEP and grant.holder_id is None


def need_first(robot: Robot, need: Need) -> str:
    """Return the reason for a grant that ends because of the need."""
    return f"the robot's own need comes first: {label_of(robot, need.kind).lower()}"


def open_need(robot: Robot, need: Need, now: datetime) -> bool:
    """Run the need's command under an upkeep grant; after a failure not before `AGAIN_S`."""
    last = newest_grant_that_moves(robot)
    failed = last is not None and serves_need(last) and last.end_code != GrantEnd.FINISHED
    if last is not None and failed and last.ended_at and 0 <= (now - last.ended_at).total_seconds() < AGAIN_S:
        return False
    limit_s = limit_of(robot, need.kind)
    put(robot, start_grant(robot, GrantKind.UPKEEP, now, until=over_by(now, limit_s)), need.kind, {}, limit_s, now)
    return True


def open_idle(robot: Robot, link: QueueRobot, now: datetime) -> bool:
    """Start one slice of idle behaviour, unless nobody has watched for long or the last slice ended at once."""
    found = _capabilities(robot, Idle)
    if not found or rests(link, now):
        return False
    idle = found[0]
    if _too_soon(robot, idle, now):
        return False
    until = now + timedelta(seconds=idle.slice_s)
    put(robot, start_grant(robot, GrantKind.IDLE, now, until=until), idle.kind, {}, idle.slice_s, now)
    return True


def _too_soon(robot: Robot, idle: Idle, now: datetime) -> bool:
    """Return whether the last slice began a moment ago or was refused lately; a preempted slice does not count."""
    last = newest_grant_that_moves(robot)
    if last is None or last.kind != GrantKind.IDLE or last.end_code == GrantEnd.PREEMPTED:
        return False
    since = (now - last.opened_at).total_seconds()
    if 0 <= since < min(AGAIN_S, idle.slice_s):
        return True
    refused = last.commands.filter(state=CommandState.REJECTED, result__code=BadRequest.code)
    return 0 <= since < REFUSED_S and refused.exists()


def rests(link: QueueRobot, now: datetime) -> bool:
    """Return whether idle behaviour pauses because nobody has watched for long."""
    if link.rest_after_min is None or link.watched_at is None:
        return False
    return now - link.watched_at > timedelta(minutes=link.rest_after_min)


def store_watchers(queue: Queue, now: datetime) -> None:
    """Store that somebody watches. People who wait for a job count as watchers.

    While no web process answers, the last viewers are assumed to be still there.
    """
    for link in links_of(queue):
        if not _capabilities(link.robot, Idle):
            continue
        if link.watched_at is not None and (now - link.watched_at).total_seconds() < NOTED_S:
            continue
        if queue.jobs.filter(state="waiting").exists() or bus.may_be_watched(link.robot.slug):
            QueueRobot.objects.filter(pk=link.pk).update(watched_at=now)


def _capabilities(robot: Robot, kind: type[C]) -> tuple[C, ...]:
    spec = spec_or_none(robot.driver)
    return spec.all_of(kind) if spec else ()
