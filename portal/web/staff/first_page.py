"""The first page of the admin: a card for each robot, numbers of today, and what waits for staff."""

from datetime import datetime
from typing import Any
from urllib.parse import urlencode

from django.db.models import F, QuerySet
from django.utils.timezone import localtime
from django.utils.translation import gettext

from portal.live.snapshot import operator_name, shown_still
from portal.web.staff.pending import Halt, halts, list_of, pending, sees_robots
from queueing.models import Job, Turn
from queueing.services import link_of, open_turn, waiting, waiting_people
from robots.grants import open_grant
from robots.kit.clock import SYSTEM
from robots.models import Incident, Robot
from robots.services.status import status_of
from robots.states import Cycle, GrantKind

LIVE = 16  # cards with live pictures; each has a socket, and a person may have 20
NAMED = 5  # people in a queue that a card names


def first_page(user: Any) -> dict[str, Any]:
    """Return what the first page shows to this member of staff."""
    now = SYSTEM.now()
    sees = sees_robots(user)
    found = halts(_all(), now) if sees else []
    cards = [_card(halt, user, now) for halt in found]
    for card in [card for card in cards if card["robot"].enabled][:LIVE]:
        card["live"] = True
    return {
        "cards": cards, "sees_robots": sees, "may_act": user.has_perm("robots.change_robot"), "now": now,
        "today": _today(user, now), "pending": pending(user, now, found),
    }  # fmt: skip


def _all() -> QuerySet[Robot]:
    """Return all robots: those that are switched on first, those for practice after the others."""
    return Robot.objects.order_by("-enabled", F("practice_for").asc(nulls_first=True), "name")


def _card(halt: Halt, user: Any, now: datetime) -> dict[str, Any]:
    robot = halt.robot
    state, label, why = status_of(robot, now)
    turn, grant, link = open_turn(robot), open_grant(robot), link_of(robot)
    maintenance = grant is not None and grant.kind == GrantKind.STAFF
    sees_people = user.has_perm("queueing.view_ticket") and link is not None
    incident = Incident.objects.filter(robot=robot).first() if user.has_perm("robots.view_incident") else None
    return {
        "robot": robot, "state": state, "label": label, "why": why, "still": shown_still(robot, user),
        "stop": halt.stop, "suspended": halt.suspended, "turn": turn,
        "operator": str(grant.holder) if maintenance and grant is not None else operator_name(turn, grant, user),
        "maintenance": maintenance, "until": turn.until if turn else grant.until if grant and maintenance else None,
        "mine": maintenance and grant is not None and grant.holder_id == user.pk,
        "locked_out": robot.cycle == Cycle.LOCKED_OUT, "waiting": waiting(robot), "queue": link.queue if link else None,
        "people": [one.user for one in waiting_people(link.queue)[:NAMED]] if sees_people and link else [],
        "incident": incident,
    }  # fmt: skip


def _today(user: Any, now: datetime) -> list[dict[str, Any]]:
    """Return numbers since midnight in the reader's zone, each with the list that it counts and the person may see."""
    midnight = localtime(now).replace(hour=0, minute=0, second=0, microsecond=0)
    shown: list[tuple[str, Any, str, str]] = [
        (gettext("Turns today"), Turn, "started_at", "queueing.view_turn"),
        (gettext("Jobs today"), Job, "asked_at", "queueing.view_job"),
        (gettext("Incidents today"), Incident, "at", "robots.view_incident"),
    ]
    return [
        {
            "words": words, "number": model.objects.filter(**{f"{field}__gte": midnight}).count(),
            "url": f"{list_of(model)}?{urlencode({f'{field}__gte': midnight.isoformat(' ')})}",
        }
        for words, model, field, permission in shown
        if user.has_perm(permission)
    ]  # fmt: skip
