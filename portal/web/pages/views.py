"""Pages: landing, story, robot, status, and the person's own; and what monitors ask for."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

from django.conf import settings
from django.contrib.auth.decorators import login_required
from django.core.exceptions import SuspiciousFileOperation
from django.db import DatabaseError, connection
from django.http import Http404, HttpRequest, HttpResponse, JsonResponse
from django.shortcuts import get_object_or_404, render
from django.utils._os import safe_join
from django.utils.cache import get_conditional_response
from django.utils.http import http_date
from django.views.decorators.cache import never_cache

from accounts.models import Clearance
from accounts.push import subscriptions_of
from accounts.services import TAKE
from operatorlog.register import register_of
from operatorlog.services import excavation_of, hidden_with, may_see_picture
from portal.live.snapshot import newest_entries, shown_still
from portal.web.alerts.models import AlertChoice, may_be_told
from portal.web.classic.pictures import has_classic_console
from portal.web.consoles.console import console_of
from portal.web.consoles.language import in_language
from portal.web.pages.cards import card_of_robot
from portal.web.pages.errors import software_missing
from queueing.models import Turn
from queueing.services import job_kinds, offers_turns, open_turn, waiting, waits_for_staff
from robots import bus
from robots.kit import description
from robots.kit.clock import SYSTEM
from robots.kit.contract.capabilities import ArmModel, Composite, Objects
from robots.kit.contract.command_packet import CommandLayout
from robots.kit.contract.compact import Layout
from robots.kit.contract.picking import PickAndPut
from robots.kit.contract.procedures import offered_procedures
from robots.kit.contract.spec import STAFF, TURN, CommandKind
from robots.models import Robot
from robots.people import driver_name, is_person
from robots.services.permissions import reaches
from robots.services.status import status_of


def _shown(robot: Robot) -> dict[str, Any]:
    state, label, why = status_of(robot, SYSTEM.now())
    return {"robot": robot, "state": state, "label": label, "why": why, "waiting": waiting(robot)}


def story(request: HttpRequest) -> HttpResponse:
    """Show what the project is for."""
    robots = Robot.objects.filter(enabled=True, practice_for=None)
    hunts = [(robot, register) for robot in robots if (register := register_of(robot)) is not None]
    return render(request, "pages/story.html", {"hunts": hunts})


@never_cache
def robot_page(request: HttpRequest, slug: str) -> HttpResponse:
    """Show one robot: everybody watches, the operator drives."""
    robot = get_object_or_404(Robot, slug=slug)
    turn = open_turn(robot)
    try:
        console = console_context(robot, request.user)
    except (LookupError, ImportError, OSError):
        return software_missing(request, robot.name)
    context = {
        **_shown(robot),
        **console,
        "operator": driver_name(turn.user, request.user) if turn else "",
        "drives": turn is not None and is_person(request.user, turn.user_id),
        "still": shown_still(robot, request.user),
        "entries": newest_entries(robot),
        "classic": has_classic_console(robot),
        "takes_jobs": bool(job_kinds(robot)),
        "digs": excavation_of(robot) is not None,
        "suspended": waits_for_staff(robot),
        "composites": robot.spec().all_of(Composite),
        "turns": offers_turns(robot),
        "twin": robot.twin,
        "card": card_of_robot(robot),
        "take": TAKE in request.session and request.session.pop(TAKE) == robot.slug,
    }
    return render(request, "pages/robot.html", context)


def _command(kind: CommandKind) -> dict[str, Any]:
    """Return the fields of a command for a console; the owner's policies are left out."""
    told = asdict(kind)
    del told["policies"]
    return told | {"asked_by": sorted(kind.asked_by)}


def console_context(robot: Robot, user: Any) -> dict[str, Any]:
    """Return the variables of a page that shows the robot's console.

    Raises LookupError, ImportError or OSError if the robot's package is not installed.
    """
    return {
        **asdict(console_of(robot.driver)),
        "description_json": in_language(console_facts(robot, user)),
        "views": description.views(robot.description()),
    }


def console_facts(robot: Robot, user: Any) -> dict[str, Any]:
    """Return what the robot's console in the browser needs to know.

    Its commands are those that the person may give in a turn: not above their clearance; to staff, also those of staff.
    """
    staff = user is not None and user.has_perm("robots.change_robot")
    described = robot.description()
    spec = robot.spec()
    facts: dict[str, Any] = {name: described[name] for name in described.get("console", {}).get("tables", ())}
    facts |= {
        "names": spec.joints,
        "channels": [asdict(channel) for channel in spec.channels],
        "pose": [{"name": c.name, "unit": c.unit} for c in spec.packed()[len(spec.channels) :]],
        "compact": layout.facts() if (layout := Layout.of(spec)) is not None else None,
        "packed": CommandLayout.of(spec).facts(),
        "streams": [asdict(stream) for stream in spec.streams],
        "cameras": len(description.views(described)),
        "video": description.coding(described),
        "words": described.get("words", {}),
        "labels": {c.kind: c.label for c in (*spec.commands, *offered_procedures(robot.driver))},
        "set": {s.name: robot.settings[s.name] for s in spec.settings() if s.shown and s.name in robot.settings},
        "settings": [c.kind for c in spec.commands if c.lane == "config"],
        "commands": [
            _command(c)
            for c in spec.commands
            if (c.open_to(TURN) or (staff and c.open_to(STAFF))) and reaches(user, robot, c.level)
        ],
    }
    if spec.capability(ArmModel) is not None:
        from robots.kit.arms.described import model_facts  # noqa: PLC0415 - arrays, which only an arm needs

        facts |= model_facts(robot.driver, f"/robots/{robot.slug}/model.urdf")
    if spec.capability(Objects) is not None:
        from robots.kit.arms.goals import goal_facts  # noqa: PLC0415 - as above
        from robots.kit.arms.objects import object_facts  # noqa: PLC0415

        facts |= object_facts(robot.driver) | goal_facts(robot.driver)
    if (picking := spec.capability(PickAndPut)) is not None:
        facts["pick_and_put"] = asdict(picking)
    return facts


def model(request: HttpRequest, slug: str) -> HttpResponse:
    """Serve the robot's URDF file."""
    robot = get_object_or_404(Robot, slug=slug)
    try:
        text = description.text_of(robot.driver, "model.urdf")
    except (ImportError, OSError) as error:
        raise Http404("This robot has no model.") from error
    response = HttpResponse(text, content_type="application/xml")
    response["Cache-Control"] = "public, max-age=300"
    return response


@never_cache
def status(request: HttpRequest) -> HttpResponse:
    """Show what works."""
    robots = [_shown(r) for r in Robot.objects.all()]
    return render(request, "pages/status.html", {"robots": robots, "link": bus.alive(), "now": SYSTEM.now()})


def livez(request: HttpRequest) -> HttpResponse:
    """Answer that this process answers; no store is used."""
    return HttpResponse("ok\n", content_type="text/plain; charset=utf-8")


def readyz(request: HttpRequest) -> HttpResponse:
    """Answer whether the database and Redis answer."""
    try:
        with connection.cursor() as cursor:
            cursor.execute("SELECT 1")
        database = True
    except DatabaseError:
        database = False
    redis = bus.alive()
    return JsonResponse({"database": database, "redis": redis}, status=200 if database else 503)


@never_cache
@login_required
def me(request: HttpRequest) -> HttpResponse:
    """Show the person's push subscriptions, clearances and turns."""
    context = {
        "clearances": Clearance.objects.filter(user=request.user.pk, revoked_at=None).select_related("robot"),
        "turns": Turn.objects.filter(user=request.user.pk).select_related("robot", "entry", "grant", "user")[:50],
        "browsers": subscriptions_of(request.user),
        "alerts": may_be_told(request.user),
        "alerts_by_mail": not AlertChoice.objects.filter(user=request.user.pk, by_mail=False).exists(),
    }
    return render(request, "pages/me.html", context)


def media(request: HttpRequest, path: str) -> HttpResponse:
    """Serve a stored picture, but not one of a turn whose entry is hidden.

    Names are never reused, so caches may keep it, but only for an hour, because it may be hidden later.
    """
    try:
        root = Path(settings.MEDIA_ROOT).absolute()
        full = Path(safe_join(str(root / "frames"), path))
        picture, kept = full.read_bytes(), full.stat()
    except (OSError, ValueError, SuspiciousFileOperation) as error:
        raise Http404("There is no such picture.") from error
    file = full.relative_to(root).as_posix()  # of `a//b` and `./b` too
    hidden = hidden_with(file)
    if hidden is not None and not may_see_picture(hidden, file, request.user):
        raise Http404("There is no such picture.")
    etag, at = f'"{kept.st_mtime_ns:x}-{kept.st_size:x}"', int(kept.st_mtime)
    response: HttpResponse = HttpResponse(picture, content_type="image/jpeg")
    response = get_conditional_response(request, etag=etag, last_modified=at, response=response) or response
    response["Cache-Control"] = "public, max-age=3600" if hidden is None else "private, no-store"
    response["ETag"], response["Last-Modified"] = etag, http_date(at)
    return response
