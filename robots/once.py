"""A form with a token (`{% once %}`) that is sent twice makes one thing: the second press leads to what the first made.

Without Redis each web process knows only what was sent to itself. Jobs, entries, answers and programs, which must never
be made twice, are told apart in the database.
"""

import hashlib
import json
import re
import time
from collections.abc import Callable

from django.core.cache import cache
from django.http import HttpRequest, HttpResponse, HttpResponseRedirect

from portal.limits.pages import leave_room

FIELD, FIELD_OF_JOBS = "once", "press"  # whoever asks for a job is also told who they are: a guest gets a cookie
TOKEN = re.compile(r"[\w-]{20,64}\Z", re.ASCII)
KNOWN_S = 86_400
WAIT_S, POLL_S = 10.0, 0.1  # for the first press, which is still being answered
BEING_ANSWERED = ""


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


class Once:
    """Middleware that carries such a form out once, and again if it was refused."""

    def __init__(self, get_response: Callable[[HttpRequest], HttpResponse]) -> None:
        self._get_response = get_response

    def __call__(self, request: HttpRequest) -> HttpResponse:
        """Answer, the second press with the redirection that the first was answered with."""
        press = press_of(request)
        if not press:
            return self._get_response(request)
        key = f"once:{press}"
        made = None if cache.add(key, BEING_ANSWERED, KNOWN_S) else _made(request, key)
        if made:
            return HttpResponseRedirect(made)
        answer = None
        try:
            answer = self._get_response(request)
        finally:
            if answer is not None and answer.status_code in (302, 303):
                cache.set(key, answer["Location"], KNOWN_S)
            else:
                cache.delete(key)
        return answer


def _made(request: HttpRequest, key: str) -> str | None:
    """Return where the first press was led to; nothing if it was refused, or is not answered in time."""
    leave_room(request)
    until = time.monotonic() + WAIT_S
    while (found := cache.get(key)) == BEING_ANSWERED and time.monotonic() < until:
        time.sleep(POLL_S)
    return str(found) if found else None
