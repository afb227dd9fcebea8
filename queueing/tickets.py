"""A person's place in a queue, from joining to its end."""

from datetime import datetime
from typing import Any

from django.db import transaction
from django.db.models import Q

from accounts.models import Clearance
from accounts.services import cleared
from queueing.charging import account_of, give_way, next_tag, settle
from queueing.errors import NotCleared, RobotUnavailable
from queueing.models import OPEN_TICKET, PlaceEnd, Queue, QueueRobot, Ticket, TicketState, Turn
from queueing.rows import QUEUE, announce, lock, queue_of, robots_of
from queueing.turns import end_turn, start_countdown
from robots.models import Robot
from robots.prepared import Prepared
from robots.services.permissions import need_staff
from robots.states import Cycle, GrantEnd

_OPEN = Q(queue=QUEUE, state__in=OPEN_TICKET)
_SUSPENDED: Prepared[Ticket] = Prepared(
    lambda: Ticket.objects.select_related("user").filter(_OPEN, user__is_active=False)
)
_UNFIT: Prepared[Ticket] = Prepared(
    lambda: Ticket.objects.select_related("user").filter(_OPEN, Q(user__is_active=False) | _uncleared())
)


def _uncleared() -> Q:
    """Return the filter of tickets whose person has no clearance for any robot of the queue."""
    return ~Q(user__in=Clearance.objects.filter(robot__queue_link__queue=QUEUE, revoked_at=None).values("user"))


def open_ticket(robot: Robot, user: Any) -> Ticket | None:
    """Return the person's open place in the robot's queue."""
    if user is None or not user.is_authenticated:
        return None
    return Ticket.objects.filter(queue__robot_links__robot=robot, user=user, state__in=OPEN_TICKET).first()


def join(robot: Robot, user: Any, now: datetime, classic: bool = False) -> Ticket:
    """Give the person a place; a person who has one keeps it.

    Raises:
        NotCleared: sign-up, orientation and test come first.
        RobotUnavailable: switched off by staff, or the robot takes jobs only.
    """
    if not cleared(user, robot):
        raise NotCleared("Pass the clearance test of this robot first.")
    if not robot.enabled:
        raise RobotUnavailable("This robot is switched off now; come back later.")
    queue = queue_of(robot)
    if not QueueRobot.objects.filter(robot=robot, offers_turns=True).exists():
        raise RobotUnavailable("Nobody drives this robot; it takes jobs only.")
    with transaction.atomic():
        queue = lock(queue)
        ticket = Ticket.objects.filter(queue=queue, user=user, state__in=OPEN_TICKET).first()
        if ticket is not None:
            Ticket.objects.filter(pk=ticket.pk).update(last_seen=now, classic=classic)
            return ticket
        account = account_of(queue, user)
        give_way(account)
        ticket = Ticket.objects.create(
            queue=queue, user=user, start_tag=next_tag(queue, account),
            joined_at=now, last_seen=now, classic=classic,
        )  # fmt: skip
        start_countdown(queue, now)
        announce(queue, user)
        return ticket


def leave(robot: Robot, user: Any, now: datetime) -> None:
    """Give up a place, an offer or a turn, if there is one."""
    ticket = open_ticket(robot, user)
    if ticket is None:
        return
    with transaction.atomic():
        queue = lock(ticket.queue)
        ticket.refresh_from_db()
        if ticket.state == TicketState.OPERATING:
            end_turn(Turn.objects.get(ticket=ticket), GrantEnd.HOLDER, "ended by the operator", now)
        elif ticket.state in OPEN_TICKET:
            withdraw(queue, ticket, TicketState.LEFT, PlaceEnd.LEFT, now)


def withdraw(queue: Queue, ticket: Ticket, state: TicketState, reason: PlaceEnd, now: datetime) -> None:
    """End a place that never became a turn; it costs nothing."""
    was = ticket.state
    Ticket.objects.filter(pk=ticket.pk).update(state=state, ended_at=now, end_reason=reason)
    if was == TicketState.OFFERED and ticket.robot_id:
        Robot.objects.filter(pk=ticket.robot_id, cycle=Cycle.OFFERED).update(cycle=Cycle.READY)
    settle(queue)
    announce(queue)


def dismiss_unfit(queue: Queue, now: datetime) -> None:
    """Remove people who were suspended or lost the clearance, also during a turn."""
    cleared_only = all(robot.clearance_required for robot in robots_of(queue))
    for ticket in (_UNFIT if cleared_only else _SUSPENDED)(queue=queue.pk):
        why = PlaceEnd.UNCLEARED if ticket.user.is_active else PlaceEnd.SUSPENDED
        remove(ticket, now, why, GrantEnd.UNFIT)


def remove(ticket: Ticket, now: datetime, reason: PlaceEnd = PlaceEnd.REMOVED, code: GrantEnd = GrantEnd.STAFF) -> bool:
    """Remove a person from the queue. Return False if the place had ended."""
    with transaction.atomic():
        queue = lock(ticket.queue)
        ticket.refresh_from_db()
        if ticket.state == TicketState.OPERATING:
            return end_turn(Turn.objects.get(ticket=ticket), code, reason, now)
        if ticket.state in OPEN_TICKET:
            withdraw(queue, ticket, TicketState.LEFT, reason, now)
            return True
        return False


def remove_by_staff(ticket: Ticket, user: Any, now: datetime) -> bool:
    """Remove a person from the queue; a running turn is ended. Return False if the place had ended. Raises NotStaff."""
    need_staff(user)
    return remove(ticket, now)
