"""Makes forms with a token (`{% once %}`) idempotent: a second press creates nothing and gets the first one's answer.

Without Redis each web process knows only the forms that it received itself. Jobs, entries, answers and programs, which
must never be created twice, have unique keys in the database.
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

FIELD, FIELD_OF_JOBS = "once", "press"  # jobs have their own: their answer also sets a guest's cookie
TOKEN = re.compile(r"[\w-]{20,64}\Z", re.ASCII)
KNOWN_S = 3_600
WAIT_S, POLL_S = 5, 0.1  # how long, and how often, a second press looks for the answer to the first one
BEING_ANSWERED = ""
PAGE = "<"  # a page begins with it, an address does not


def token_of(request: HttpRequest, name: str = FIELD) -> str:
    """Return the token of the form that was sent; empty if it has none."""
    token = request.POST.get(name, "") if request.method == "POST" else ""
    return token if TOKEN.match(token) else ""


def press_of(request: HttpRequest, name: str = FIELD) -> str:
    """Return a digest of the form with its token, which only a second press repeats; empty without a token."""
    if not token_of(request, name):
        return ""
    sent = sorted((key, values) for key, values in request.POST.lists() if key != "csrfmiddlewaretoken")
    return hashlib.sha256(json.dumps([request.path, sent]).encode()).hexdigest()


def once(view: Callable[..., HttpResponse]) -> Callable[..., HttpResponse]:
    """Return the view so that it handles each form with a token once for each person; a refused form may come again.

    The view may answer with a redirection, or with the page that closes the admin's popup, only after a success.
    Therefore the check of the sign-in wraps this decorator, and a refusal that redirects passes it as an exception.
    """

    @wraps(view)
    def checked(request: HttpRequest, *args: Any, **kwargs: Any) -> HttpResponse:
        press = press_of(request)
        if not press:
            return view(request, *args, **kwargs)
        key = f"once:{request.user.pk}:{press}"
        stored = None if cache.add(key, BEING_ANSWERED, WAIT_S) else _made(request, key)
        if stored:
            return HttpResponse(stored) if stored.startswith(PAGE) else HttpResponseRedirect(stored)
        try:
            answer = view(request, *args, **kwargs)
            stored = answer.get("Location") or _page_that_closes(answer)
        finally:
            cache.set(key, stored, KNOWN_S) if stored else cache.delete(key)
        return answer

    return checked


def _page_that_closes(answer: HttpResponse) -> str | None:
    """Return the page that closes the admin's popup and gives the form behind it the new row; None for any other."""
    if isinstance(answer, TemplateResponse) and "popup_response_data" in (answer.context_data or {}):
        return str(answer.render().content.decode())
    return None


def _made(request: HttpRequest, key: str) -> str | None:
    """Return the address or page that answered the first press; None if it was refused or is not answered in time."""
    getattr(request, "leave_room", bool)()  # another page is rendered meanwhile (portal/edge/pages.py)
    until = SYSTEM.awake() + WAIT_S
    while (stored := cache.get(key)) == BEING_ANSWERED and SYSTEM.awake() < until:
        SYSTEM.sleep(POLL_S)
    return str(stored) if stored else None
