"""The console for browsers without scripts: same robot, same rules; no GET moves anything."""

import re
import secrets
from datetime import datetime
from typing import Any

from django.contrib import messages
from django.http import HttpRequest, HttpResponse
from django.shortcuts import get_object_or_404, redirect, render
from django.utils.translation import gettext
from django.views.decorators.cache import never_cache

from accounts.services import cleared
from portal.edge.pages import leave_room
from portal.live.snapshot import newest_entries, shown_still
from portal.web.classic.models import fresh_token, spend_token
from portal.web.classic.pictures import has_classic_console, name_of
from portal.web.consoles.console import classic
from queueing import services as queue
from queueing.errors import QueueError
from queueing.models import Ticket, Turn
from queueing.services import End, end_of_turn, idle_at, is_news, last_turn, place_and_wait
from robots import services
from robots.bus.web_uptime import up_since
from robots.grants import grant_of
from robots.kit.clock import SYSTEM, ms_of
from robots.kit.contract.errors import RobotError
from robots.kit.drivers.panels import Panel, Press, panel_of
from robots.models import Command, Frame, Robot
from robots.people import is_person
from robots.sentences import translate
from robots.services import newest_still, stop_shown
from robots.services.status import status_of

WAIT_S = 20.0
POLL_S = 0.1
REFRESH_S, DRIVING_S = 30, 60  # the second one for the operator: before `CLASSIC_PRESENCE_S` is over
WARN_S, TOLD_S = 30, 3  # before and after the end of a turn in which nothing is done
PIXEL = re.compile(r"[0-9]{1,5}\Z")


@never_cache
def enter(request: HttpRequest, slug: str) -> HttpResponse:
    """Redirect to an address with a fresh token."""
    robot = get_object_or_404(Robot, slug=slug)
    return redirect(_address(robot, request)) if has_classic_console(robot) else _without(request, robot)


def _without(request: HttpRequest, robot: Robot) -> HttpResponse:
    """Answer that this robot has no classic console, and which console it has."""
    return render(request, "classic/none.html", {"robot": robot}, status=404)


def _address(robot: Robot, request: HttpRequest, now: datetime | None = None) -> str:
    still = newest_still(robot)
    if not request.user.is_authenticated:
        return f"/classic/{robot.slug}/{secrets.token_urlsafe(24)}/"
    token = fresh_token(robot, request.user, now or SYSTEM.now(), still.pk if still else 0)
    return f"/classic/{robot.slug}/{token}/"


@never_cache
def page(request: HttpRequest, slug: str, token: str) -> HttpResponse:
    """Show the page for the person's present role; a request counts as presence."""
    robot = get_object_or_404(Robot, slug=slug)
    panel = panel_of(robot.driver) if has_classic_console(robot) else None
    if panel is None:
        return _without(request, robot)
    if request.method == "POST":
        return _act(request, robot, panel, token)
    now = SYSTEM.now()
    if request.user.is_authenticated:
        queue.note_presence(robot, request.user, now, classic=True)
    return render(request, "classic/page.html", _context(request, robot, panel, now))


def _context(request: HttpRequest, robot: Robot, panel: Panel, now: datetime) -> dict[str, Any]:
    state, label, why = status_of(robot, now)
    ticket = queue.open_ticket(robot, request.user)
    turn = queue.open_turn(robot)
    still = shown_still(robot, request.user)
    mine = turn is not None and is_person(request.user, turn.user_id)
    ahead, wait = place_and_wait(robot, ticket, now) if ticket else (0, None)
    ends = idle_at(turn, now, up_since(now)) if turn is not None and mine else None
    idle_s = max(0, round((ends - now).total_seconds())) if ends is not None else None
    unwritten = None
    if request.user.is_authenticated:
        unwritten = Turn.objects.filter(user=request.user, robot=robot, entry=None).exclude(ended_at=None).first()
    address = _address(robot, request, now)
    return {
        "robot": robot, "state": state, "label": label, "why": why, "ticket": ticket, "turn": turn, "mine": mine,
        "ahead": ahead, "wait": wait, "still": still,
        "over": _over(robot, request.user, now) if ticket is None else None,
        "address": address, "picture": f"/classic/{robot.slug}/{name_of(robot, still, request.user)}.gif",
        "cleared": cleared(request.user, robot), "refresh_s": _refresh_s(ticket, idle_s if mine else None, mine),
        "idle_s": idle_s, "warned": idle_s is not None and idle_s <= WARN_S,
        "age_s": round((now - still.taken_at).total_seconds()) if still else None,
        "left_s": round((turn.until - now).total_seconds()) if turn else None,
        "offer_s": round((ticket.offer_until - now).total_seconds()) if ticket and ticket.offer_until else None,
        "sizes": {"large": (panel.WIDTH * 2, panel.HEIGHT * 2), "small": (panel.WIDTH, panel.HEIGHT)},
        "buttons": classic(robot.driver), "unwritten": unwritten, "stop": stop_shown(robot, now),
        "entries": newest_entries(robot),
    }  # fmt: skip


def _over(robot: Robot, user: Any, now: datetime) -> End | None:
    """Return the words for the person's turn here, if it ended lately."""
    turn = last_turn(robot, user) if user.is_authenticated else None
    return end_of_turn(turn) if turn is not None and is_news(turn, now) else None


def _refresh_s(ticket: Ticket | None, idle_s: int | None, mine: bool) -> int | None:
    """Return after how many seconds the page reloads; an idle operator's page reloads in time to warn."""
    if ticket is None:
        return None
    if not mine:
        return REFRESH_S
    if idle_s is None:
        return DRIVING_S
    return min(DRIVING_S, idle_s + TOLD_S if idle_s <= WARN_S else max(TOLD_S, idle_s - WARN_S + 1))


def _act(request: HttpRequest, robot: Robot, panel: Panel, token: str) -> HttpResponse:
    """Carry out one press; a token allows at most one motion."""
    if not request.user.is_authenticated:
        return redirect(f"/accounts/login/?next=/classic/{robot.slug}/")
    now = SYSTEM.now()
    queue.note_presence(robot, request.user, now, classic=True)
    try:
        _perform(request, robot, panel, token, now)
    except (RobotError, QueueError) as error:
        messages.warning(request, translate(error))
    return redirect(_address(robot, request))


def _perform(request: HttpRequest, robot: Robot, panel: Panel, token: str, now: datetime) -> None:
    user = request.user
    what = request.POST.get("do", "")
    if what in queue.PLACE_ACTS:
        queue.change_place(what, robot, user, now, queue.Page(classic=True))
    elif what == "stop":
        _stop(request, robot, now)
    elif what == "release":
        services.release_stop(robot, user, request.POST.get("checked") == "yes")
        queue.note_act(robot, user, now)
        messages.success(request, gettext("The stop is released. Nothing moves until you give a command."))
    else:
        _press(request, robot, panel, token, now)


def _stop(request: HttpRequest, robot: Robot, now: datetime) -> None:
    services.stop(robot, request.user, now)
    queue.note_act(robot, request.user, now)
    messages.warning(request, gettext("Stop was sent. Look at the picture, then release the stop."))


def _press(request: HttpRequest, robot: Robot, panel: Panel, token: str, now: datetime) -> None:
    wanted = _wanted(request, robot, panel)
    if wanted is None:
        messages.warning(request, gettext("Nothing was pressed. Click in the picture or on a button."))
        return
    if wanted.kind == "stop":
        _stop(request, robot, now)
        return
    spent = spend_token(robot, request.user, token, now)
    if spent is None:
        messages.warning(request, gettext("That page was used before, so nothing moved. This is the current page."))
        return
    args = {**wanted.args, "still": spent.still} if "still" in wanted.args else wanted.args
    grant = grant_of(robot, request.user, now)
    seen = Frame.objects.filter(pk=spent.still).first() if spent.still else None
    command = services.issue(
        robot.slug, request.user, wanted.kind, args, services.next_seq(grant), now, ms_of(seen.taken_at) if seen else 0
    ).command
    leave_room(request)
    _tell(request, _until_final(command))


def _wanted(request: HttpRequest, robot: Robot, panel: Panel) -> Press | None:
    if (asked := panel.form(request.POST.dict())) is not None:
        return asked
    for name, scale in (("small", 1), ("large", 2)):
        x, y = request.POST.get(f"{name}.x", ""), request.POST.get(f"{name}.y", "")
        if PIXEL.match(x) and PIXEL.match(y):
            return panel.press(int(x), int(y), 0, robot.description(), scale)
    return None


def _until_final(command: Command) -> Command:
    """Wait for the end of the command, as the page of 1994 did, for a limited time."""
    until = SYSTEM.awake() + WAIT_S
    while not command.final and SYSTEM.awake() < until:
        SYSTEM.sleep(POLL_S)
        command.refresh_from_db()
    return command


def _tell(request: HttpRequest, command: Command) -> None:
    label, state = queue.label_of(command.robot, command.kind), command.get_state_display()
    text = f"{translate(label)}: {translate(state).lower()}."
    if command.reason:
        text += f" {translate(command.reason)}"
    if command.state == "completed":
        messages.success(request, text)
    else:
        messages.warning(request, text)
