"""`/embed/...`: pages that other sites may show in a frame, and the only ones; and pictures of moments.

They use no session and no cookie, so they show what everybody may see, and there is nothing to operate in them: a page
that frames them cannot make anybody press a button of the portal.
"""

from collections.abc import Callable
from typing import Any

from csp.decorators import csp_replace
from django.contrib.auth.models import AnonymousUser
from django.http import Http404, HttpRequest, HttpResponse, HttpResponseBase
from django.shortcuts import get_object_or_404
from django.template.loader import render_to_string
from django.views.decorators.clickjacking import xframe_options_exempt
from django.views.decorators.http import require_safe

from portal.web.pages.serving import limit_rate
from portal.web.recordings import access, moments
from portal.web.recordings.views import busy, index_of, readable
from robots.kit import description
from robots.kit.clock import SYSTEM
from robots.models import Robot
from robots.recordings import keeping
from robots.services.status import status_of

NO_PICTURE = "There is no picture at that time."


def framable(view: Callable[..., HttpResponseBase]) -> Callable[..., HttpResponseBase]:
    """Let any site show the page in a frame."""
    free: Callable[..., HttpResponseBase] = xframe_options_exempt(view)
    return csp_replace({"frame-ancestors": ["*"]})(free)  # type: ignore[arg-type, return-value]


def _page(template: str, context: dict[str, Any]) -> HttpResponse:
    """Return a page made without the request: nothing of its session can be in it."""
    return HttpResponse(render_to_string(template, context), headers={"Cache-Control": "public, max-age=30"})


@framable
@require_safe
@limit_rate()
def recording(request: HttpRequest, key: str) -> HttpResponse:
    """Show the pictures of a recording, one a second."""
    found, about = access.visible(key, AnonymousUser())
    if about is None or about.hidden:
        raise Http404(access.NONE)
    second, said = moments.moment_in(request.GET.get("t", ""), found)
    length = moments.length_s(found)
    context = {
        "recording": found, "about": about, "robot": found.robot, "second": second, "said": said, "length": length,
        "picture": moments.picture_address(found, second),
        "facts": {"pictures": f"{found.get_absolute_url()}{found.version}/moment-", "length": length, "at": second},
    }  # fmt: skip
    return _page("embed/recording.html", context)


@framable
@require_safe
@limit_rate()
def robot(request: HttpRequest, slug: str) -> HttpResponse:
    """Show a robot's newest picture and state."""
    found = get_object_or_404(Robot, slug=slug, enabled=True)
    _, label, why = status_of(found, SYSTEM.now())
    try:
        seen = bool(description.views(found.description()))
    except (ImportError, OSError):
        seen = False
    return _page("embed/robot.html", {"robot": found, "label": label, "why": why, "seen": seen})


@require_safe
@limit_rate()
def picture(request: HttpRequest, key: str, version: int, second: int) -> HttpResponseBase:
    """Return the picture of a moment; caches keep one that everybody may see for an hour, for it may be hidden."""
    recording = readable(request, key, version)
    if second > moments.length_s(recording) + 1:
        raise Http404("The recording is shorter.")
    known = index_of(recording)
    if known is None:
        return busy()
    from robots.kit.recording.timeline import picture_at  # noqa: PLC0415 - the reader is loaded when it is needed

    try:
        jpeg = picture_at(keeping.path_of(recording), known, second * 1000)
    except OSError as error:
        raise Http404("The recording cannot be read.") from error
    if jpeg is None:
        raise Http404(NO_PICTURE)
    about = access.about(recording)
    public = about is not None and not about.hidden
    return HttpResponse(
        jpeg, content_type="image/jpeg",
        headers={"Cache-Control": "public, max-age=3600" if public else "private, no-store"},
    )  # fmt: skip
