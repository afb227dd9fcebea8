"""The landing page: a robot that moves, large and live, all others as cards, and the way to driving."""

from datetime import datetime
from typing import Any

from django.http import HttpRequest, HttpResponse
from django.shortcuts import get_object_or_404, redirect, render

from accounts.confirm import entrance
from accounts.services import cleared, has_read
from operatorlog.models import Entry, Visibility
from operatorlog.register import newest_find, place_said
from operatorlog.services import hidden_of
from portal.live.snapshot import is_free, moves, operator_name, shown_still
from portal.live.watchers import watching_now
from queueing.models import OPEN_TICKET, Turn
from queueing.services import CLOSED, join_said, offers_turns, open_turn, standings, wait_if_joined, waiting
from robots.grants import open_grant
from robots.kit import description
from robots.kit.clock import SYSTEM
from robots.models import Frame, Robot
from robots.services.status import status_of

ENTRIES = 3
LOOP = 24  # pictures of the last turn that are shown one after another


def landing(request: HttpRequest) -> HttpResponse:
    """Show the robots, live."""
    now, robots = SYSTEM.now(), list(Robot.objects.filter(enabled=True, practice_for=None))
    watching = watching_now([robot.slug for robot in robots])
    cards = [_card(robot, request.user, now) | {"watching": watching.get(robot.slug, 0)} for robot in robots]
    placed = {one.robot for one in standings(request.user, now) if one.state in OPEN_TICKET}
    for card in cards:
        card["wait"] = "" if card["robot"] in placed else _wait(card, now)
    entries = Entry.objects.exclude(visibility=Visibility.HIDDEN).select_related("author", "robot", "frame", "turn")
    lead, find = _lead(cards), newest_find()
    pictured = entries.exclude(frame=None).first() if find is None else None
    others = [card for card in cards if card is not lead]
    to_drive = _to_drive(lead, others)
    context = {
        "lead": lead, "cards": others, "drive": to_drive, "loop": _loop(lead), "pictured": pictured,
        "find": find, "place": place_said(find) if find else None,
        "practice": _to_practise(to_drive or (lead["robot"] if lead else None), now),
        "entries": [entry for entry in entries[: ENTRIES + 1] if entry != pictured][:ENTRIES],
    }  # fmt: skip
    return render(request, "pages/landing.html", context)


def drive(request: HttpRequest, slug: str) -> HttpResponse:
    """Go on, on the way to driving a robot, where this person stands: account, orientation, test, or its page."""
    robot = get_object_or_404(Robot, slug=slug)
    if robot.practice:
        return redirect(robot)
    if not request.user.is_authenticated:
        return redirect(entrance(request, request.path))
    if cleared(request.user, robot):
        return redirect(robot)
    return redirect("clearance" if has_read(request.user, robot) else "orientation", slug)


def _card(robot: Robot, user: Any, now: datetime) -> dict[str, Any]:
    state, label, _ = status_of(robot, now)
    turn, turns = open_turn(robot), offers_turns(robot)
    return {
        "robot": robot, "state": state, "label": label, "turns": turns, "turn": turn, "moves": moves(state, label),
        "operator": operator_name(turn, open_grant(robot), user) or "", "still": shown_still(robot, user),
        "blind": _no_camera(robot),
    }  # fmt: skip


def _wait(card: dict[str, Any], now: datetime) -> str:
    """Return how long somebody who joins now would wait, in words."""
    robot, state = card["robot"], card["state"]
    if state in CLOSED or not card["turns"]:
        return ""
    wait = wait_if_joined(robot, now)
    return join_said(state, is_free(state, card["label"], waiting(robot), wait), wait)


def _lead(cards: list[dict[str, Any]]) -> dict[str, Any] | None:
    """Return the card of a robot that moves: the turn that began last, else by itself, else the one driven last."""
    seen = [card for card in cards if not card["blind"] and card["state"] not in CLOSED] or cards
    driven = [card for card in seen if card["turn"]]
    if driven:
        return max(driven, key=lambda card: card["turn"].started_at)
    moving = next((card for card in seen if card["moves"]), None)
    if moving is not None:
        return moving
    last = Turn.objects.filter(robot__in=[card["robot"] for card in seen]).order_by("-id").first()
    by_last = [card for card in seen if last is not None and card["robot"].pk == last.robot_id]
    return next(iter(by_last + seen), None)


def _to_drive(lead: dict[str, Any] | None, others: list[dict[str, Any]]) -> Robot | None:
    """Return the robot that the button is about: the large one, unless it is closed or offers no turns."""
    open_now = [card for card in (lead, *others) if card is not None and card["turns"] and card["state"] not in CLOSED]
    return open_now[0]["robot"] if open_now else None


def _to_practise(led: Robot | None, now: datetime) -> Robot | None:
    """Return the simulator that guests are offered: of the robot that is offered, else one that is free at once."""
    open_now: list[tuple[bool, bool, Robot]] = []
    twins = Robot.objects.filter(enabled=True, guest_s__isnull=False, practice_for__isnull=False)
    for twin in twins.select_related("practice_for"):
        state, label, _ = status_of(twin, now)
        if state not in CLOSED:
            free = is_free(state, label, waiting(twin), wait_if_joined(twin, now))
            open_now.append((twin.practice_for == led, free, twin))
    return max(open_now, key=lambda one: one[:2])[2] if open_now else None


def _loop(lead: dict[str, Any] | None) -> dict[str, Any] | None:
    """Return the pictures of the last turn, for a robot that rests; None if there are too few, or it moves."""
    if lead is None or lead["moves"]:
        return None
    turn = Turn.objects.filter(robot=lead["robot"]).exclude(ended_at=None).order_by("-id").first()
    if turn is None or hidden_of(turn.grant_id) is not None:
        return None
    frames = Frame.objects.filter(grant=turn.grant_id).order_by("-id")[:LOOP]
    shown = [frame.url for frame in reversed(frames)]
    return {"turn": turn, "urls": shown} if len(shown) > 1 else None


def _no_camera(robot: Robot) -> bool:
    """Return whether the robot is known to have no camera; False if its package is not installed."""
    try:
        return not description.views(robot.description())
    except (ImportError, OSError):
        return False
