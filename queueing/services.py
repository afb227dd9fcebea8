"""Join, leave, accept, end, tick: whose turn it is. One verb, one function.

Every change of a queue happens under a lock of its row (PostgreSQL) or of the database
(SQLite, immediate transactions), so two ticks or two people cannot interleave.
"""

from datetime import datetime, timedelta
from typing import Any

from django.conf import settings
from django.db import transaction
from django.db.models import F, Q

from accounts.models import Clearance
from accounts.services import cleared
from queueing import fairshare
from queueing.errors import NotCleared, NotYourTurn, RobotUnavailable
from queueing.models import NOT_YET, OPEN_TICKET, Account, Queue, QueueRobot, Ticket, TicketState, Turn
from queueing.offers import RobotsFault, begin, offer, recall, recall_offers, why_not_ready
from queueing.rows import announce, locked, robots_of
from robots import bus
from robots.grants import end_grant, end_overdue_upkeep
from robots.messages import StandingChanged
from robots.models import Grant, Robot
from robots.states import Cycle

RULES = settings.FARHAND
ABSENT_S = 900  # a waiting person who is away so long has left
SLICE_S = 60
NO_ANSWER = "did not answer the offer"


def queue_of(robot: Robot) -> Queue:
    """Return the queue that serves the robot; a new robot gets one of its own."""
    link = QueueRobot.objects.select_related("queue").filter(robot=robot).first()
    if link is not None:
        return link.queue
    with transaction.atomic():
        queue = Queue.objects.create(name=f"Queue of {robot.name}")
        return QueueRobot.objects.create(robot=robot, queue=queue).queue


def open_ticket(robot: Robot, user: Any) -> Ticket | None:
    """Return the person's open place in the robot's queue."""
    if user is None or not user.is_authenticated:
        return None
    return Ticket.objects.filter(queue__robot_links__robot=robot, user=user, state__in=OPEN_TICKET).first()


def open_turn(robot: Robot) -> Turn | None:
    """Return the turn that runs on the robot."""
    return Turn.objects.select_related("user", "grant", "ticket").filter(robot=robot, ended_at=None).first()


def turn_of(robot: Robot, user: Any) -> Turn | None:
    """Return the person's running turn on the robot."""
    turn = open_turn(robot)
    return turn if turn and user is not None and turn.user_id == user.pk else None


def join(robot: Robot, user: Any, now: datetime, classic: bool = False) -> Ticket:
    """Give the person a place; who has one keeps it.

    Raises:
        NotCleared: sign-up, orientation and test come first.
        RobotUnavailable: switched off by staff.

    """
    if not cleared(user, robot):
        raise NotCleared("Pass the clearance test of this robot first.")
    if not robot.enabled:
        raise RobotUnavailable("This robot is switched off now; come back later.")
    queue = queue_of(robot)
    with transaction.atomic():
        queue = locked(queue)
        ticket = Ticket.objects.filter(queue=queue, user=user, state__in=OPEN_TICKET).first()
        if ticket is not None:
            Ticket.objects.filter(pk=ticket.pk).update(last_seen=now, classic=classic)
            return ticket
        account, _ = Account.objects.get_or_create(queue=queue, user=user)
        clock = fairshare.Clock(queue.virtual_time, queue.greatest_finish)
        ticket = Ticket.objects.create(
            queue=queue, user=user, start_tag=fairshare.start_tag(clock, account.finish_tag),
            joined_at=now, last_seen=now, classic=classic,
        )  # fmt: skip
        _start_countdown(queue, now)
        announce(queue, user)
        return ticket


def _start_countdown(queue: Queue, now: datetime) -> None:
    """Bound a newcomer's wait: a turn in its extra time ends in a minute."""
    for turn in Turn.objects.select_related("grant").filter(robot__queue_link__queue=queue, ended_at=None):
        end = max(turn.base_until, now + timedelta(seconds=RULES["COUNTDOWN_S"]))
        if turn.until > end:
            _set_until(turn, end)


def _set_until(turn: Turn, until: datetime) -> None:
    turn.until = until
    Turn.objects.filter(pk=turn.pk).update(until=until)
    Grant.objects.filter(pk=turn.grant_id, ended_at=None).update(until=until)


def leave(robot: Robot, user: Any, now: datetime) -> None:
    """Give up one's place, offer or turn. Nothing happens where there is none."""
    ticket = open_ticket(robot, user)
    if ticket is None:
        return
    with transaction.atomic():
        queue = locked(ticket.queue)
        ticket.refresh_from_db()
        if ticket.state == TicketState.OPERATING:
            end_turn(Turn.objects.get(ticket=ticket), "ended by the operator", now)
        elif ticket.state in OPEN_TICKET:
            _withdraw(queue, ticket, TicketState.LEFT, "left the queue", now)


def _withdraw(queue: Queue, ticket: Ticket, state: TicketState, reason: str, now: datetime) -> None:
    was = ticket.state
    Ticket.objects.filter(pk=ticket.pk).update(state=state, ended_at=now, end_reason=reason)
    if was == TicketState.OFFERED and ticket.robot_id:
        Robot.objects.filter(pk=ticket.robot_id, cycle=Cycle.OFFERED).update(cycle=Cycle.READY)
    _settle_clock(queue)
    announce(queue)


def _settle_clock(queue: Queue) -> None:
    if not Ticket.objects.filter(queue=queue, state__in=OPEN_TICKET).exists():
        clock = fairshare.Clock(queue.virtual_time, queue.greatest_finish).empty()
        Queue.objects.filter(pk=queue.pk).update(virtual_time=clock.virtual)
        queue.virtual_time = clock.virtual


def accept(robot: Robot, user: Any, now: datetime) -> Turn:
    """Take up an offer: grant and turn begin.

    Raises:
        NotYourTurn: no open offer of this person's.
        NotCleared: suspended, or the clearance was withdrawn, since the offer.
        RobotUnavailable: the robot fell out of order since the offer; the place is kept.

    """
    ticket = open_ticket(robot, user)
    if ticket is not None and ticket.state == TicketState.OPERATING:
        return Turn.objects.get(ticket=ticket)  # a double click, a reload
    try:
        return _accept(ticket, now)
    except RobotsFault as fault:
        assert ticket is not None
        with transaction.atomic():
            recall(locked(ticket.queue), ticket, fault.robot)
        raise RobotUnavailable(f"{fault.why.rstrip('.')}. You keep your place and are offered it again.") from fault


def _accept(ticket: Ticket | None, now: datetime) -> Turn:
    with transaction.atomic():
        if ticket is None:
            raise NotYourTurn("The robot is not offered to you now.")
        queue = locked(ticket.queue)
        ticket.refresh_from_db()
        if ticket.state != TicketState.OFFERED or ticket.offer_until is None or ticket.offer_until <= now:
            raise NotYourTurn("The offer is over; join the queue again.")
        robot = Robot.objects.get(pk=ticket.robot_id or 0)
        if not cleared(ticket.user, robot):
            raise NotCleared("You are no longer cleared for this robot.")
        problem = why_not_ready(robot, now, Cycle.OFFERED)
        if problem:
            raise RobotsFault(robot, problem)
        turn = begin(queue, robot, ticket, now)
        announce(queue)
        return turn


def end_turn(turn: Turn, reason: str, now: datetime) -> bool:
    """End a turn, charge it, and send the robot to be put in order; False if it had ended."""
    with transaction.atomic():
        queue = locked(turn.ticket.queue)
        used = (min(now, turn.until) - turn.started_at).total_seconds()
        seconds = fairshare.charged(used, turn.alone_s)
        done = Turn.objects.filter(pk=turn.pk, ended_at=None).update(ended_at=now, end_reason=reason, charged_s=seconds)
        if not done:
            return False
        end_grant(turn.grant, reason, now)
        Ticket.objects.filter(pk=turn.ticket_id).update(state=TicketState.DONE, ended_at=now, end_reason=reason)
        account, _ = Account.objects.get_or_create(queue=queue, user=turn.user)
        tag = fairshare.finish_tag(turn.ticket.start_tag, seconds, account.weight)
        Account.objects.filter(pk=account.pk).update(finish_tag=tag)
        clock = fairshare.Clock(queue.virtual_time, queue.greatest_finish).finish(tag)
        Queue.objects.filter(pk=queue.pk).update(greatest_finish=clock.greatest_finish)
        queue.greatest_finish = clock.greatest_finish
        Robot.objects.filter(pk=turn.robot_id, cycle=Cycle.OPERATING).update(cycle=Cycle.HANDOVER)
        _settle_clock(queue)
        announce(queue)
        return True


def seen(robot: Robot, user: Any, now: datetime, classic: bool | None = None) -> None:
    """Count a heartbeat or a request as presence."""
    ticket = open_ticket(robot, user)
    if ticket is None:
        return
    changes: dict[str, Any] = {"last_seen": now}
    if classic is not None:
        changes["classic"] = classic
    Ticket.objects.filter(pk=ticket.pk).update(**changes)
    if ticket.state == TicketState.OPERATING:
        mine = Turn.objects.filter(ticket=ticket, ended_at=None)
        back = mine.filter(connected=False).update(connected=True)
        mine.update(**changes)
        if back:
            bus.tell_people_on_commit(StandingChanged(user=user.pk))


def disconnected(robot: Robot, user: Any, now: datetime) -> None:
    """Remember that the operator's line is gone; the turn is kept for a while."""
    mine = Turn.objects.filter(robot=robot, user=user, ended_at=None, classic=False)
    if mine.update(connected=False, last_seen=now):
        bus.tell_people_on_commit(StandingChanged(user=user.pk))


def tick(now: datetime) -> None:
    """Let time pass in every queue: end, expire, lengthen, offer. Safe to run twice at once."""
    for queue in Queue.objects.all():
        with transaction.atomic():
            _tick(locked(queue), now)


def _tick(queue: Queue, now: datetime) -> None:
    for robot in robots_of(queue):
        end_overdue_upkeep(robot, now)
    _dismiss(queue, now)
    for turn in Turn.objects.select_related("grant", "ticket", "user").filter(
        robot__queue_link__queue=queue, ended_at=None
    ):
        _tick_turn(queue, turn, now)
    recall_offers(queue, now)  # first: an offer that nobody could take up must not lapse
    for ticket in Ticket.objects.filter(queue=queue, state=TicketState.OFFERED, offer_until__lte=now):
        _withdraw(queue, ticket, TicketState.EXPIRED, NO_ANSWER, now)
    for ticket in Ticket.objects.filter(
        queue=queue, state=TicketState.WAITING, last_seen__lte=now - timedelta(seconds=ABSENT_S)
    ):
        _withdraw(queue, ticket, TicketState.EXPIRED, "was away too long", now)
    if not queue.paused:
        offer(queue, now)


def _dismiss(queue: Queue, now: datetime) -> None:
    """Take out who was suspended or lost the clearance, also in mid-turn."""
    suspended, lost = Q(user__is_active=False), Q()
    if not any(not robot.clearance_required for robot in robots_of(queue)):
        kept = Clearance.objects.filter(robot__queue_link__queue=queue, revoked_at=None)
        lost = ~Q(user__in=kept.values("user"))
    tickets = Ticket.objects.select_related("user").filter(queue=queue, state__in=OPEN_TICKET)
    for ticket in tickets.filter(suspended | lost if lost else suspended):
        remove(ticket, now, "clearance withdrawn" if ticket.user.is_active else "account suspended")


def _tick_turn(queue: Queue, turn: Turn, now: datetime) -> None:
    grant = turn.grant
    grant.refresh_from_db()
    queued = Ticket.objects.filter(queue=queue, state__in=NOT_YET)
    others = queued.order_by("joined_at").values_list("joined_at", flat=True).first()
    silent = (now - turn.last_seen).total_seconds()
    idle = (now - max(_last_act(turn), others or now)).total_seconds()  # counted while others wait
    if grant.ended_at is not None:
        end_turn(turn, grant.end_reason or "ended", grant.ended_at)
    elif not others and turn.until - now <= timedelta(seconds=5) and silent < RULES["RECONNECT_S"]:
        extra = min(SLICE_S, RULES["TURN_S"])
        Turn.objects.filter(pk=turn.pk).update(alone_s=F("alone_s") + extra)
        _set_until(turn, turn.until + timedelta(seconds=extra))
        announce(queue)
    elif turn.until <= now:
        end_turn(turn, "time is up", now)
    elif (not turn.classic and not turn.connected and silent > RULES["RECONNECT_S"]) or (
        turn.classic and silent > RULES["CLASSIC_PRESENCE_S"]
    ):
        end_turn(turn, "connection lost", now)
    elif others and idle > RULES["CLASSIC_IDLE_S" if turn.classic else "IDLE_S"]:
        end_turn(turn, "idle while others wait", now)


def _last_act(turn: Turn) -> datetime:
    last = turn.grant.commands.order_by("-id").values_list("created_at", flat=True).first()
    return max(turn.started_at, last) if last else turn.started_at


def remove(ticket: Ticket, now: datetime, reason: str = "removed by staff") -> None:
    """Take a person out of the queue (staff)."""
    with transaction.atomic():
        queue = locked(ticket.queue)
        ticket.refresh_from_db()
        if ticket.state == TicketState.OPERATING:
            end_turn(Turn.objects.get(ticket=ticket), reason, now)
        elif ticket.state in OPEN_TICKET:
            _withdraw(queue, ticket, TicketState.LEFT, reason, now)
