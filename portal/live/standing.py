"""A person's places as pages and sockets show them, and the person's acts there."""

from collections.abc import Sequence
from datetime import datetime
from typing import Any

from queueing import services as queue
from queueing.errors import QueueError
from robots.kit.clock import ms_of
from robots.models import Robot


def place_info(one: queue.Standing, now: datetime) -> dict[str, Any]:
    """Return the fields of one place for a page; `left_s` is for pages without scripts."""
    until = min((at for at in (one.kept_until or one.until, one.idle_at) if at), default=None)
    words = {"why": one.end.why, "credited": one.end.credited, "next": one.end.next} if one.end else None
    return {
        "state": one.state, "ticket": one.ticket, "robot": one.robot.slug, "name": one.robot.name,
        "simulated": one.robot.simulated,
        "until_ms": ms_of(one.until), "kept_until_ms": ms_of(one.kept_until), "ahead": one.ahead, "wait_s": one.wait_s,
        "idle_ms": ms_of(one.idle_at), "ended_ms": ms_of(one.ended_at), "away": one.away, "end": words,
        "turn": one.turn, "left_s": max(0, round((until - now).total_seconds())) if until else None,
    }  # fmt: skip


def places(standings: Sequence[queue.Standing], now: datetime) -> dict[str, Any]:
    """Return everything that the bar on every page shows, the most urgent place first."""
    return {"t": "places", "now_ms": ms_of(now), "places": [place_info(one, now) for one in standings]}


def act(user: Any, wanted: str, robot: str, ticket: int, now: datetime, session: str = "") -> str:
    """Join, leave, accept, stay or dismiss from any page. Return what went wrong as a sentence, or an empty text.

    `session`: the key of the page's session.
    """
    if wanted == "dismiss":
        queue.dismiss(ticket, user, now)
        return ""
    found = Robot.objects.filter(slug=robot).first()
    if found is None:
        return "There is no such robot; reload the page."
    try:
        queue.change_place(wanted, found, user, now, queue.Page(session, away=True))
    except QueueError as error:
        return str(error)
    return ""
