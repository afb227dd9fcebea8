"""`/me/places/`: the person's places, for pages without a socket or without scripts."""

from django.contrib import messages
from django.contrib.auth.decorators import login_required
from django.http import HttpRequest, HttpResponse, HttpResponseBase, HttpResponseRedirect, JsonResponse
from django.shortcuts import redirect
from django.utils.http import url_has_allowed_host_and_scheme
from django.views.decorators.cache import never_cache
from django.views.decorators.http import require_http_methods

from portal.live.standing import act, places
from queueing.services import note_waiting, standings
from robots.kit.clock import SYSTEM
from robots.kit.plain import whole
from robots.sentences import translate


@never_cache
@require_http_methods(["GET", "POST"])
@login_required
def my_places(request: HttpRequest) -> HttpResponseBase:
    """Return the person's places (GET, JSON), or accept, leave, join or dismiss one (POST).

    A form is redirected to a page; a script asks for JSON and gets `text`, which says what went wrong.
    """
    now = SYSTEM.now()
    note_waiting(request.user, now)
    if request.method != "POST":
        return JsonResponse(_places(request))
    wanted, robot = request.POST.get("do", ""), request.POST.get("robot", "")
    number = whole(request.POST.get("ticket", "")) or 0
    wrong = translate(act(request.user, wanted, robot, number, now, request.session.session_key or ""))
    if request.accepts("text/html"):
        return _go_on(request, wanted, robot, wrong)
    return JsonResponse({**_places(request), "ok": not wrong, "text": wrong})


def _places(request: HttpRequest) -> dict[str, object]:
    now = SYSTEM.now()
    return places(standings(request.user, now), now)


def _go_on(request: HttpRequest, wanted: str, robot: str, wrong: str) -> HttpResponse:
    """Redirect a browser without scripts to the accepted robot, or back to where it was.

    `own` is the robot of that page: a person at its classic console stays there.
    """
    if wrong:
        messages.warning(request, wrong)
    elif wanted in ("accept", "join") and request.POST.get("own") != robot:
        return redirect("robot", slug=robot)
    return back_from(request)


def back_from(request: HttpRequest) -> HttpResponseRedirect:
    """Redirect to the page of this site from which a form was sent."""
    back = request.POST.get("next", "")
    safe = url_has_allowed_host_and_scheme(back, {request.get_host()}, request.is_secure())
    return HttpResponseRedirect(back if safe else "/")
