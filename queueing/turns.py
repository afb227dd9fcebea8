"""Turns: the running one, its time, and its end."""

import logging
from datetime import UTC, datetime, timedelta
from typing import Any

from django.conf import settings
from django.db import Error, transaction
from django.db.models import BigAutoField, F, QuerySet

from queueing import fairshare
from queueing.charging import account_of, charge, settle
from queueing.models import NOT_YET, Job, JobState, Queue, Ticket, TicketState, Turn
from queueing.rows import QUEUE, announce, is_suspended, link_of, lock
from robots import bus
from robots.grants import end_grant
from robots.kit.packets import StandingChanged
from robots.models import Command, Grant, Robot
from robots.people import is_person
from robots.prepared import Prepared, Slot
from robots.services.permissions import need_staff
from robots.states import COMMAND_FINAL, Cycle, GrantEnd

log = logging.getLogger(__name__)
RULES = settings.FARHAND
SLICE_S = 60
ALWAYS = datetime.min.replace(tzinfo=UTC)
GRANT, ROBOT, USER = (Slot(name, BigAutoField()) for name in ("grant", "robot", "user"))
_FIRST_QUEUED: Prepared[Any] = Prepared(
    lambda: (
        Ticket.objects.filter(queue=QUEUE, state__in=NOT_YET)
        .order_by("joined_at")
        .values_list("joined_at", flat=True)[:1]
    )
)
_FIRST_ASKED: Prepared[Any] = Prepared(
    lambda: (
        Job.objects.filter(robot=ROBOT, state=JobState.WAITING, start_tag__isnull=False)
        .exclude(user=USER)
        .order_by("asked_at")
        .values_list("asked_at", flat=True)[:1]
    )
)
_UNDER_WAY: Prepared[Command] = Prepared(lambda: _theirs().exclude(state__in=COMMAND_FINAL).only("pk")[:1])
_LAST_ENDED: Prepared[Any] = Prepared(
    lambda: _theirs().filter(ended_at__isnull=False).order_by("-ended_at").values_list("ended_at", flat=True)[:1]
)


def _theirs() -> QuerySet[Command]:
    """Return the commands that the person gave under the grant."""
    return Command.objects.filter(grant=GRANT, robot=ROBOT, issued_by=USER)


def times_as_long(person: Any) -> int:
    """Return how many times as long as usual a person has for what they do; nobody (None) has the usual time."""
    return 1 if person is None else int(person.turn_factor)


def length_of_turn(robot: Robot, person: Any = None) -> float:
    """Return the length of the person's turn on the robot (s), without extra time; None: of a usual one."""
    own = robot.guest_s if person is not None and person.guest else robot.turn_s
    return float(own or RULES["TURN_S"]) * times_as_long(person)


def countdown_s(turn: Turn) -> float:
    """Return how long a turn in its extra time goes on after somebody else has come (s)."""
    return float(RULES["COUNTDOWN_S"] * times_as_long(turn.user))


def open_turn(robot: Robot) -> Turn | None:
    """Return the turn that runs on the robot."""
    return Turn.objects.select_related("user", "grant", "ticket").filter(robot=robot, ended_at=None).first()


def turn_of(robot: Robot, user: Any) -> Turn | None:
    """Return the person's running turn on the robot."""
    turn = open_turn(robot)
    return turn if turn and is_person(user, turn.user_id) else None


def start_countdown(queue: Queue, now: datetime, job: Job | None = None) -> None:
    """Limit the wait of a newcomer, or of another person's `job`: a turn in its extra time ends after `countdown_s`."""
    turns = Turn.objects.select_related("grant", "user").filter(robot__queue_link__queue=queue, ended_at=None)
    if job is not None:
        turns = turns.filter(robot=job.robot).exclude(user=job.user)
    for turn in turns:
        end = max(turn.base_until, now + timedelta(seconds=countdown_s(turn)))
        if turn.until > end:
            set_until(turn, end)


def set_until(turn: Turn, until: datetime) -> None:
    """Move the end of a turn and of its grant."""
    turn.until = until
    Turn.objects.filter(pk=turn.pk).update(until=until)
    Grant.objects.filter(pk=turn.grant_id, ended_at=None).update(until=until)


def end_turn(turn: Turn, code: GrantEnd, reason: str, now: datetime) -> bool:
    """End a turn, charge it, and send the robot into handover. Return False if it had ended."""
    ticket = turn.ticket
    if ticket is None:  # its person's account was deleted, and it had ended before
        return False
    with transaction.atomic():
        queue = lock(ticket.queue)
        used = (min(now, turn.until) - turn.started_at).total_seconds()
        seconds = fairshare.chargeable_s(used, turn.alone_s)
        done = Turn.objects.filter(pk=turn.pk, ended_at=None).update(ended_at=now, end_reason=reason, charged_s=seconds)
        if not done:
            return False
        turn.sessions.all().delete()
        end_grant(turn.grant, code, reason, now)
        Ticket.objects.filter(pk=ticket.pk).update(state=TicketState.DONE, ended_at=now, end_reason=reason)
        # who needs more time for the same has as many turns as others
        charge(queue, account_of(queue, turn.user), ticket.start_tag, seconds / times_as_long(turn.user))
        Robot.objects.filter(pk=turn.robot_id, cycle=Cycle.OPERATING).update(cycle=Cycle.HANDOVER)
        settle(queue)
        announce(queue)
        return True


def end_by_staff(turn: Turn, user: Any, now: datetime) -> bool:
    """End a running turn. Return False if it had ended. Raises NotStaff."""
    need_staff(user)
    return end_turn(turn, GrantEnd.STAFF, "ended by staff", now)


def tick_turn(queue: Queue, turn: Turn, now: datetime, up_since: datetime = ALWAYS) -> None:
    """Extend the turn while nobody waits; end it if time is up, or its operator is gone or idle while others wait.

    The turn of a guest is not extended.

    `up_since`: people can reach the portal since then; nobody counts as gone or idle before.
    """
    grant = turn.grant
    grant.refresh_from_db()
    others = others_wait_since(turn)
    absent = (now - max(turn.last_seen, up_since)).total_seconds()
    ends = _idle_at(turn, others, now, up_since)
    if grant.ended_at is not None:
        end_turn(turn, GrantEnd(grant.end_code or GrantEnd.FINISHED), grant.end_reason or "ended", grant.ended_at)
    elif (
        not others
        and not _of_guest(turn)
        and turn.until - now <= timedelta(seconds=5)
        and absent < RULES["RECONNECT_S"]
    ):
        extra = min(SLICE_S, RULES["TURN_S"])
        Turn.objects.filter(pk=turn.pk).update(alone_s=F("alone_s") + extra)
        set_until(turn, turn.until + timedelta(seconds=extra))
        announce(queue)
    elif turn.until <= now:
        end_turn(turn, GrantEnd.TIME_UP, "time is up", now)
    elif not turn.classic and not turn.connected and absent > RULES["RECONNECT_S"]:
        end_turn(turn, GrantEnd.ABSENT, "connection lost", now)
    elif turn.classic and absent > RULES["CLASSIC_PRESENCE_S"]:
        end_turn(turn, GrantEnd.SILENT, "no request came", now)
    elif ends is not None and now > ends:
        end_turn(turn, GrantEnd.IDLE, "idle while others wait", now)


def _of_guest(turn: Turn) -> bool:
    return turn.user is not None and turn.user.guest


def idle_at(turn: Turn, now: datetime, up_since: datetime = ALWAYS) -> datetime | None:
    """Return when the turn ends unless its operator does something; None if nobody waits, or its time is up before."""
    at = _idle_at(turn, others_wait_since(turn), now, up_since)
    return at if at is not None and at < turn.until else None


def _idle_at(turn: Turn, others: datetime | None, now: datetime, up_since: datetime) -> datetime | None:
    """Return the end of the idle time, counted from the operator's last act or from the begin of the first wait."""
    if others is None:
        return None
    return max(_last_act(turn, now), others, up_since) + timedelta(seconds=idle_s(turn))


def idle_s(turn: Turn) -> int:
    """Return how long the operator may do nothing while others wait (s)."""
    return int(RULES["CLASSIC_IDLE_S" if turn.classic else "IDLE_S"]) * times_as_long(turn.user)


def stay(robot: Robot, user: Any, now: datetime) -> bool:
    """Note that the operator has done something other than a command, or says that they are there.

    Return False if they have no turn, or it has ended.
    """
    turn = turn_of(robot, user)
    ticket = turn.ticket if turn is not None else None
    if turn is None or ticket is None:
        return False
    with transaction.atomic():
        lock(ticket.queue)  # so a tick either has ended the turn before, or judges it after this
        if not Turn.objects.filter(pk=turn.pk, ended_at=None).update(acted_at=now):
            return False
        bus.tell_people_on_commit(StandingChanged(user=user.pk))
        return True


def note_act(robot: Robot, user: Any, now: datetime) -> None:
    """Note an act of the operator as `stay` does, but wait for no tick, and raise no error of the database.

    It serves stops, which are answered at once. While another transaction changes the row, nothing is noted.
    """
    try:
        with transaction.atomic():
            running = Turn.objects.select_for_update(skip_locked=True).filter(robot=robot, ended_at=None)
            mine = running.filter(user=user.pk, user__isnull=False)
            if mine.first() is not None:
                mine.update(acted_at=now)
                bus.tell_people_on_commit(StandingChanged(user=user.pk))
    except Error:
        log.warning("an act of the operator of %s was not noted", robot.slug, exc_info=True)


def others_wait_since(turn: Turn) -> datetime | None:
    """Return since when another person waits for the robot, in the queue or for a job; None if nobody does."""
    if turn.ticket is None:  # its person's account was deleted
        return None
    people = _FIRST_QUEUED.first(queue=turn.ticket.queue_id)
    asked = _FIRST_ASKED.first(robot=turn.robot_id, user=turn.user_id)
    link = link_of(turn.robot) if asked is not None else None
    if asked is not None and is_suspended(turn.robot, link):
        asked = None  # it waits for staff
    elif asked is not None and link is not None and link.resumed_at is not None:
        asked = max(asked, link.resumed_at)  # before, it waited for staff
    return min((at for at in (people, asked) if at is not None), default=None)


def _last_act(turn: Turn, now: datetime) -> datetime:
    """Return when the operator last did something; now, while a command of theirs runs.

    Settings that staff change under the grant do not count.
    """
    theirs = {"grant": turn.grant_id, "robot": turn.robot_id, "user": turn.user_id}
    if _UNDER_WAY(**theirs):
        return now
    acts: tuple[datetime | None, ...] = (turn.started_at, turn.acted_at, *_LAST_ENDED(**theirs))
    return max(at for at in acts if at is not None)
