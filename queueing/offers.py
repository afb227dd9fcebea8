"""Offers: made, taken back and accepted. A fault of the robot costs nobody their place."""

from datetime import datetime, timedelta
from typing import Any

from django.conf import settings
from django.db import IntegrityError, transaction
from django.db.models import BooleanField, DateTimeField, Exists, ExpressionWrapper, F, OuterRef, Q, QuerySet

from accounts.models import PushSubscription
from accounts.services import cleared, cleared_people
from accounts.turn_mails import told_by_mail
from queueing.charging import serve
from queueing.errors import NotCleared, NotYourTurn, RobotUnavailable
from queueing.models import Queue, Ticket, TicketState, Turn, TurnSession
from queueing.rows import QUEUE, announce, lock
from queueing.tickets import open_ticket
from queueing.turns import ALWAYS, end_turn, length_of_turn, times_as_long
from robots.grants import ROBOT, lease_of, open_grant, owner_alive, start_grant
from robots.kit.contract.errors import NotPermitted
from robots.models import Robot
from robots.prepared import Prepared, PreparedUpdate, Slot
from robots.sentences import english
from robots.states import Cycle, GrantEnd, GrantKind

RULES = settings.FARHAND
REACHABLE = timedelta(hours=2)  # so long after a person was seen, an offer is made to them if they are told elsewhere
BACK = timedelta(seconds=40)  # within this time after a start of the portal, pages connect again
CHANGED = "The robot is no longer offered."
ELSEWHERE = "You operate another robot now; end that turn first."
IN_USE = {
    GrantKind.JOB: "A job runs on the robot now.", GrantKind.IDLE: "The robot moves by itself now.",
    GrantKind.UPKEEP: "A command of staff or for its upkeep runs on the robot now.",
    GrantKind.STAFF: "Staff operate the robot now.", GrantKind.HANDOVER: "The robot is being put in order.",
    GrantKind.SETTINGS: "The robot is being put in order.", GrantKind.REST: "The robot comes to rest.",
}  # fmt: skip
NOW = Slot("now", DateTimeField())
_OFFERED: Prepared[Ticket] = Prepared(
    lambda: Ticket.objects.select_related("robot").filter(queue=QUEUE, state=TicketState.OFFERED)
)
_WITHOUT_OFFER: PreparedUpdate[Robot] = PreparedUpdate(
    lambda: Robot.objects.filter(queue_link__queue=QUEUE, cycle=Cycle.OFFERED).exclude(
        pk__in=Ticket.objects.filter(queue=QUEUE, state=TicketState.OFFERED).values("robot")
    ),
    cycle=Cycle.READY,
)
_WITHOUT_TURN: PreparedUpdate[Robot] = PreparedUpdate(
    lambda: Robot.objects.filter(queue_link__queue=QUEUE, cycle=Cycle.OPERATING).exclude(
        pk__in=Turn.objects.filter(robot__queue_link__queue=QUEUE, ended_at=None).values("robot")
    ),
    cycle=Cycle.HANDOVER,
)
_PUSH_DUE: Prepared[Ticket] = Prepared(
    lambda: Ticket.objects.select_related("user", "robot").filter(push_due=True).order_by("offer_until", "pk")
)
_MAIL_DUE: Prepared[Ticket] = Prepared(
    lambda: (
        Ticket.objects.select_related("user", "robot")
        .filter(mail_due=True, state=TicketState.OFFERED, offer_until__gt=NOW)
        .order_by("offer_until", "pk")
    )
)
_FIRST: Prepared[Any] = Prepared(lambda: _there()[:1])
_FIRST_CLEARED: Prepared[Any] = Prepared(lambda: _there().filter(user__in=cleared_people(ROBOT))[:1])


def _there() -> QuerySet[Ticket]:
    """Return the tickets that may come next, in order: of people present, `reachable`, or last seen before `back`.

    The latter may not have connected again yet.
    """
    heard = Q(last_seen__gte=Slot("present", DateTimeField())) | Q(last_seen__lt=Slot("back", DateTimeField()))
    waiting = Ticket.objects.annotate(reachable=reachable()).filter(heard | Q(reachable=True))
    waiting = waiting.filter(queue=QUEUE, state=TicketState.WAITING).exclude(user__is_active=False)
    busy = Turn.objects.filter(ended_at=None, user__isnull=False, robot__practice_for=None).values("user_id")
    return waiting.exclude(user__in=busy).order_by("start_tag", "id")


def reachable() -> Any:
    """Return whether a ticket's person is away, but a browser of theirs or an e-mail tells them of an offer.

    Not if they let an offer pass since they were seen: it kept others waiting, and is made to them again when they are
    back. Its slot is `reachable`.
    """
    browser = Exists(PushSubscription.objects.filter(user=OuterRef("user")))
    told = browser | Exists(told_by_mail().filter(user=OuterRef("user")))
    since_seen = Q(offer_until=None) | Q(offer_until__lt=F("last_seen"))
    is_reachable = Q(told) & since_seen & Q(last_seen__gte=Slot("reachable", DateTimeField()))
    return ExpressionWrapper(is_reachable, output_field=BooleanField())


class RobotsFault(Exception):
    """The robot cannot be used now, and the person is not the cause."""

    def __init__(self, robot: Robot, why: str) -> None:
        super().__init__(why)
        self.robot, self.why = robot, why


def begin(queue: Queue, robot: Robot, ticket: Ticket, now: datetime, away: bool = False, session: str = "") -> Turn:
    """Start the turn of an accepted offer; `away`: the robot's page is not open yet.

    `session`: the key of the session in which it was accepted. It is stored at once, not with the page's next report:
    so a person who signs out of another session meanwhile keeps the turn.

    Raises:
        RobotsFault: the robot is no longer offered, or somebody else may move it.
        RobotUnavailable: the person operates another robot.
    """
    until = now + timedelta(seconds=length_of_turn(robot, ticket.user))
    _leave_practice(ticket.user, now)
    try:
        with transaction.atomic():
            # this row first: a lock-out at the same moment either waits for it and then ends the grant, or came before
            if not Robot.objects.filter(pk=robot.pk, cycle=Cycle.OFFERED, enabled=True).update(cycle=Cycle.OPERATING):
                raise RobotsFault(robot, why_not_ready(Robot.objects.get(pk=robot.pk), now, Cycle.OFFERED) or CHANGED)
            grant = start_grant(robot, GrantKind.TURN, now, ticket.user, until)
            turn = Turn.objects.create(
                robot=robot, user=ticket.user, ticket=ticket, grant=grant, classic=ticket.classic,
                started_at=now, base_until=until, until=until, last_seen=now, connected=not away,
            )  # fmt: skip
            if session:
                TurnSession.objects.create(turn=turn, session=session, last_seen=now)
    except NotPermitted as error:
        raise RobotsFault(robot, str(error)) from error
    except IntegrityError as error:  # a turn of theirs started at the same moment on another robot
        raise RobotUnavailable(ELSEWHERE) from error
    Ticket.objects.filter(pk=ticket.pk).update(state=TicketState.OPERATING, last_seen=now)
    serve(queue, ticket.start_tag)
    return turn


def _leave_practice(user: Any, now: datetime) -> None:
    """End the turn in which the person practises. Raises RobotUnavailable if they operate a robot."""
    mine = Turn.objects.select_related("robot", "grant", "ticket", "user").filter(user=user, ended_at=None).first()
    if mine is not None and not mine.robot.practice:
        raise RobotUnavailable(ELSEWHERE)
    if mine is not None:
        end_turn(mine, GrantEnd.HOLDER, "went on to another robot", now)


def why_not_ready(
    robot: Robot, now: datetime, cycle: Cycle = Cycle.READY, giving_way: frozenset[GrantKind] = frozenset()
) -> str:
    """Return why the robot cannot be offered now; empty if it can, also under a grant of the kinds in `giving_way`."""
    if not robot.enabled:
        return "The robot is switched off."
    if robot.cycle != cycle:
        return robot.reason or f"The robot is not ready: {english(Cycle(robot.cycle).label)}."
    if not owner_alive(lease_of(robot), now):
        return "The robot's worker does not answer; it is being restarted."
    grant = open_grant(robot)
    if grant is not None and grant.kind not in giving_way:
        return IN_USE.get(GrantKind(grant.kind), "Somebody else may move the robot now.")
    return ""


def accept(robot: Robot, user: Any, now: datetime, away: bool = False, session: str = "") -> Turn:
    """Accept an offer: grant and turn start.

    `away`: the person accepts on another page; the turn then waits for the robot's page as after a lost connection.
    `session`: the key of that page's session.

    Raises:
        NotYourTurn: the person has no open offer.
        NotCleared: suspended, or the clearance was withdrawn, since the offer.
        RobotUnavailable: the robot failed since the offer; the place is kept.
    """
    ticket = open_ticket(robot, user)
    if ticket is not None and ticket.state == TicketState.OPERATING:
        return Turn.objects.get(ticket=ticket)  # a double click, a reload
    try:
        return _accept(ticket, now, away, session)
    except RobotsFault as fault:
        assert ticket is not None
        with transaction.atomic():
            recall(lock(ticket.queue), ticket, fault.robot)
        raise RobotUnavailable(f"{fault.why.rstrip('.')}. You keep your place and are offered it again.") from fault


def _accept(ticket: Ticket | None, now: datetime, away: bool, session: str) -> Turn:
    with transaction.atomic():
        if ticket is None:
            raise NotYourTurn("The robot is not offered to you now.")
        queue = lock(ticket.queue)
        ticket.refresh_from_db()
        if ticket.state == TicketState.OPERATING:
            return Turn.objects.get(ticket=ticket)  # by a click at the same moment
        if ticket.state != TicketState.OFFERED or ticket.offer_until is None or ticket.offer_until <= now:
            raise NotYourTurn("The offer is over; join the queue again.")
        robot = Robot.objects.get(pk=ticket.robot_id or 0)
        if not cleared(ticket.user, robot):
            raise NotCleared("You are no longer cleared for this robot.")
        problem = why_not_ready(robot, now, Cycle.OFFERED)
        if problem:
            raise RobotsFault(robot, problem)
        turn = begin(queue, robot, ticket, now, away, session)
        announce(queue)
        return turn


def recall_offers(queue: Queue, now: datetime) -> None:
    """Take back offers of robots that are no longer in order."""
    for ticket in open_offers(queue):
        robot = ticket.robot
        if robot is None or why_not_ready(robot, now, Cycle.OFFERED):
            recall(queue, ticket, robot)
    _WITHOUT_OFFER(queue=queue.pk)
    _WITHOUT_TURN(queue=queue.pk)


def open_offers(queue: Queue) -> list[Ticket]:
    """Return the tickets with an open offer."""
    return _OFFERED(queue=queue.pk)


def recall(queue: Queue, ticket: Ticket, robot: Robot | None, passed: bool = False) -> None:
    """Take an offer back; the place is kept. `passed`: because a person who is away did not answer it."""
    back = Ticket.objects.filter(pk=ticket.pk, state=TicketState.OFFERED)
    if back.update(state=TicketState.WAITING, robot=None, offer_until=ticket.offer_until if passed else None):
        if robot is not None:
            Robot.objects.filter(pk=robot.pk, cycle=Cycle.OFFERED).update(cycle=Cycle.READY)
        announce(queue)


def head(queue: Queue, robot: Robot, now: datetime, up_since: datetime = ALWAYS) -> Ticket | None:
    """Return the ticket of the first person who is present or reachable, may drive this robot and operates no other.

    None while somebody before them may not have come back yet: people can reach the portal only since `up_since`.
    """
    present = now - timedelta(seconds=RULES["PRESENCE_S"])
    back = up_since if now - up_since < BACK else ALWAYS
    values = {"queue": queue.pk, "present": present, "back": back, "reachable": now - REACHABLE}
    found = _FIRST_CLEARED if robot.clearance_required else _FIRST  # of several robots in a queue
    first = found.first(**values, robot=robot.pk)
    return first if first is not None and (first.last_seen >= present or first.reachable) else None


def make_offer(queue: Queue, robot: Robot, ticket: Ticket, now: datetime) -> None:
    """Offer a robot that is ready to the ticket's person."""
    if not Robot.objects.filter(pk=robot.pk, cycle=Cycle.READY).update(cycle=Cycle.OFFERED):
        return
    Ticket.objects.filter(pk=ticket.pk).update(
        state=TicketState.OFFERED, robot=robot, offer_until=now + _length(ticket),
        push_due=PushSubscription.objects.filter(user=ticket.user_id).exists(),
        mail_due=told_by_mail().filter(user=ticket.user_id).exists(),
    )  # fmt: skip
    announce(queue)


def take_due_pushes(now: datetime) -> list[Ticket]:
    """Return the open offers of which nobody has told the browsers of their people yet; the caller does, and once."""
    found = [one for one in _PUSH_DUE() if Ticket.objects.filter(pk=one.pk, push_due=True).update(push_due=False)]
    return [
        one for one in found
        if one.state == TicketState.OFFERED and one.robot is not None and one.offer_until and one.offer_until > now
    ]  # fmt: skip


def due_mails(now: datetime) -> list[Ticket]:
    """Return the open offers of which no mail has told their people yet, the most urgent first."""
    return _MAIL_DUE(now=now)


def take_due_mail(ticket: Ticket, now: datetime) -> bool:
    """Return whether the offer still stands and no mail tells of it yet; the caller sends one."""
    return bool(_of_offer(ticket).filter(mail_due=True, offer_until__gt=now).update(mail_due=False))


def give_mail_back(ticket: Ticket) -> None:
    """Note that the mail of an offer was not sent; as long as the offer stands, it is due again."""
    _of_offer(ticket).update(mail_due=True)


def _of_offer(ticket: Ticket) -> QuerySet[Ticket]:
    return Ticket.objects.filter(pk=ticket.pk, state=TicketState.OFFERED, offer_until=ticket.offer_until)


def was_away(ticket: Ticket) -> bool:
    """Return whether the person was away when the offer was made, and has not been seen since."""
    return ticket.last_seen < made_at(ticket) - timedelta(seconds=RULES["PRESENCE_S"])


def _length(ticket: Ticket) -> timedelta:
    usual = timedelta(seconds=RULES["CLASSIC_OFFER_S" if ticket.classic else "OFFER_S"])
    return usual * times_as_long(ticket.user)


def made_at(ticket: Ticket) -> datetime:
    """Return when the open offer was made."""
    assert ticket.offer_until is not None
    return ticket.offer_until - _length(ticket)
