"""Landing, story, robot, status and one's own page."""

from pathlib import Path
from typing import Any

from django.conf import settings
from django.contrib.auth.decorators import login_required
from django.http import FileResponse, Http404, HttpRequest, HttpResponse
from django.shortcuts import get_object_or_404, render
from django.utils._os import safe_join
from django.views.decorators.cache import never_cache

from accounts.models import Clearance
from operatorlog.models import Entry, Visibility
from portal.live.snapshot import status_of
from queueing.models import Turn
from queueing.services import open_turn, waiting
from robots import bus
from robots.clock import SYSTEM
from robots.models import Robot
from robots.services import newest_still


def _shown(robot: Robot) -> dict[str, Any]:
    state, label, why = status_of(robot, SYSTEM.now())
    return {"robot": robot, "state": state, "label": label, "why": why, "waiting": waiting(robot)}


def landing(request: HttpRequest) -> HttpResponse:
    """Show the robots, live."""
    robots = [{**_shown(r), "still": newest_still(r)} for r in Robot.objects.filter(enabled=True)]
    entries = Entry.objects.exclude(visibility=Visibility.HIDDEN).select_related("author", "robot", "frame", "turn")
    return render(request, "pages/landing.html", {"robots": robots, "entries": entries[:3]})


def story(request: HttpRequest) -> HttpResponse:
    """Tell why."""
    return render(request, "pages/story.html")


@never_cache
def robot_page(request: HttpRequest, slug: str) -> HttpResponse:
    """Show one robot: everybody watches, the operator drives."""
    robot = get_object_or_404(Robot, slug=slug)
    turn = open_turn(robot)
    described = robot.description()
    context = {
        **_shown(robot),
        "operator": turn.user.username if turn else "",
        "still": newest_still(robot),
        "entries": Entry.objects.filter(robot=robot).exclude(visibility=Visibility.HIDDEN).select_related("author")[:5],
        "description_json": {k: described[k] for k in ("arm", "sand") if k in described},
    }
    return render(request, "pages/robot.html", context)


@never_cache
def status(request: HttpRequest) -> HttpResponse:
    """Tell what works."""
    robots = [_shown(r) for r in Robot.objects.all()]
    return render(request, "pages/status.html", {"robots": robots, "link": bus.alive(), "now": SYSTEM.now()})


@never_cache
@login_required
def me(request: HttpRequest) -> HttpResponse:
    """Show one's clearances and turns."""
    context = {
        "clearances": Clearance.objects.filter(user=request.user.pk, revoked_at=None).select_related("robot"),
        "turns": Turn.objects.filter(user=request.user.pk).select_related("robot", "entry")[:50],
    }
    return render(request, "pages/me.html", context)


def media(request: HttpRequest, path: str) -> FileResponse:
    """Serve a kept picture; names are never reused, so caches may keep it."""
    try:
        full = Path(safe_join(str(Path(settings.MEDIA_ROOT) / "frames"), path))
        file = full.open("rb")
    except (OSError, ValueError) as error:
        raise Http404("There is no such picture.") from error
    response = FileResponse(file, content_type="image/jpeg")
    response["Cache-Control"] = "public, max-age=31536000, immutable"
    return response
