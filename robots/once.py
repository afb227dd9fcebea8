"""A form with a token (`{% once %}`) that is sent twice makes one thing: the second press leads to what the first made.

Without Redis each web process knows only what was sent to itself. Jobs, entries, answers and programs, which must never
be made twice, are told apart in the database.
"""

import hashlib
import json
import re
from collections.abc import Callable
from functools import wraps
from typing import Any

from django.core.cache import cache
from django.http import HttpRequest, HttpResponse, HttpResponseRedirect
from django.template.response import TemplateResponse

from robots.kit.clock import SYSTEM

FIELD, FIELD_OF_JOBS = "once", "press"  # whoever asks for a job is also told who they are: a guest gets a cookie
TOKEN = re.compile(r"[\w-]{20,64}\Z", re.ASCII)
KNOWN_S = 3_600
WAIT_S, POLL_S = 5, 0.1  # for the first press, which is still being answered
BEING_ANSWERED = ""
PAGE = "<"  # how a page begins, and no address


def token_of(request: HttpRequest, name: str = FIELD) -> str:
    """Return the token of the form that was sent; empty if it has none."""
    token = request.POST.get(name, "") if request.method == "POST" else ""
    return token if TOKEN.match(token) else ""


def press_of(request: HttpRequest, name: str = FIELD) -> str:
    """Return what a second press repeats, and a form that was filled in anew does not; empty without a token."""
    if not token_of(request, name):
        return ""
    sent = sorted((key, values) for key, values in request.POST.lists() if key != "csrfmiddlewaretoken")
    return hashlib.sha256(json.dumps([request.path, sent]).encode()).hexdigest()


def once(view: Callable[..., HttpResponse]) -> Callable[..., HttpResponse]:
    """Make a view carry such a form out once for each person, and again if it was refused.

    Only what was made may be answered with a redirection, or with the page by which the admin's small window closes:
    the check of who is signed in stands around this, and a refusal that redirects too is raised through it.
    """

    @wraps(view)
    def checked(request: HttpRequest, *args: Any, **kwargs: Any) -> HttpResponse:
        press = press_of(request)
        if not press:
            return view(request, *args, **kwargs)
        key = f"once:{request.user.pk}:{press}"
        told = None if cache.add(key, BEING_ANSWERED, WAIT_S) else _made(request, key)
        if told:
            return HttpResponse(told) if told.startswith(PAGE) else HttpResponseRedirect(told)
        try:
            answer = view(request, *args, **kwargs)
            told = answer.get("Location") or _page_that_closes(answer)
        finally:
            cache.set(key, told, KNOWN_S) if told else cache.delete(key)
        return answer

    return checked


def _page_that_closes(answer: HttpResponse) -> str | None:
    """Return the page that tells the form behind the admin's small window what was made; None for any other."""
    if isinstance(answer, TemplateResponse) and "popup_response_data" in (answer.context_data or {}):
        return str(answer.render().content.decode())
    return None


def _made(request: HttpRequest, key: str) -> str | None:
    """Return where the first press was led to, or the page; nothing if it was refused, or is not answered in time."""
    getattr(request, "leave_room", bool)()  # another page is rendered meanwhile (portal/edge/pages.py)
    until = SYSTEM.awake() + WAIT_S
    while (told := cache.get(key)) == BEING_ANSWERED and SYSTEM.awake() < until:
        SYSTEM.sleep(POLL_S)
    return str(told) if told else None
