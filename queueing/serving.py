"""Starts the next thing of each robot: its needs, then turns and jobs in order of their tags, then idle behaviour."""

from datetime import datetime

from queueing.charging import tag_next
from queueing.idle import need_first, open_idle, open_need, serves_need, store_watchers, wanted_need
from queueing.jobs.judging import head_of
from queueing.jobs.running import promote
from queueing.models import Job, Queue, QueueRobot, Ticket
from queueing.offers import head, make_offer, why_not_ready
from queueing.rows import announce, is_suspended, links_of
from queueing.turns import ALWAYS
from robots.grants import end_grant, newest_grant_that_moves, open_grant
from robots.models import Grant, Robot
from robots.states import GIVES_WAY_TO_QUEUE, Cycle, GrantEnd, GrantKind

ASKED, TURN_NEXT = "somebody asked for the robot", "somebody's turn comes next"


def serve_next(queue: Queue, now: datetime, up_since: datetime = ALWAYS) -> None:
    """Start the next thing on each robot that is ready. `up_since`: people can reach the portal since then."""
    tag_next(queue)
    store_watchers(queue, now)
    for link in links_of(queue):
        _serve(queue, link, now, up_since)


def _serve(queue: Queue, link: QueueRobot, now: datetime, up_since: datetime) -> None:
    robot = link.robot
    grant = open_grant(robot)
    if why_not_ready(robot, now, giving_way=GIVES_WAY_TO_QUEUE):
        return
    idle = grant is None or grant.kind == GrantKind.IDLE
    ticket = head(queue, robot, now, up_since) if idle and link.offers_turns else None
    if is_suspended(robot, link):
        if ticket is not None and idle:
            _to_a_person(queue, robot, grant, ticket, now)
        return
    need = wanted_need(robot, now)
    if need is not None:
        if _gives_way(robot, grant, need_first(robot, need), now):
            open_need(robot, need, now)
        return
    job = head_of(robot, link) if idle else None
    if ticket is not None and (job is None or _before(ticket, job)):
        _to_a_person(queue, robot, grant, ticket, now)
    elif job is not None:
        if _gives_way(robot, grant, ASKED, now):
            promote(queue, job, now)
    elif grant is None:
        open_idle(robot, link, now)


def _before(ticket: Ticket, job: Job) -> bool:
    return (ticket.start_tag, ticket.joined_at) <= (job.start_tag or 0.0, job.asked_at)


def _gives_way(robot: Robot, grant: Grant | None, reason: str, now: datetime) -> bool:
    """End the grant for the next thing. Return False if the robot comes to rest first."""
    if grant is None:
        return True
    end_grant(grant, GrantEnd.PREEMPTED, reason, now)
    return open_grant(robot) is None


def _to_a_person(queue: Queue, robot: Robot, grant: Grant | None, ticket: Ticket, now: datetime) -> None:
    """Offer the robot; after a job or a motion of its own it goes into handover first."""
    _gives_way(robot, grant, TURN_NEXT, now)
    last = newest_grant_that_moves(robot)
    if last is not None and (last.kind in (GrantKind.JOB, GrantKind.IDLE) or serves_need(last)):
        Robot.objects.filter(pk=robot.pk, cycle=Cycle.READY).update(cycle=Cycle.HANDOVER)
        announce(queue)
    else:
        make_offer(queue, robot, ticket, now)
