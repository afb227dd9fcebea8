"""Error pages that say what was wrong and what to do.

Each is also rendered where no middleware has run, then without the menu and without a query.
"""

import sys
from collections.abc import Sequence

from django.db import Error
from django.http import HttpRequest, HttpResponse, HttpResponseNotAllowed
from django.shortcuts import render
from django.template.loader import render_to_string

from portal.stores import down_text


def _bare(heading: str, text: str, ours: bool = True) -> str:
    """Return a page without menu; `ours`: with style and a link, which a browser asks of the host that it named."""
    return render_to_string("bare.html", {"heading": heading, "text": text, "ours": ours})


def _page(request: HttpRequest, status: int, heading: str, text: str) -> HttpResponse:
    if not hasattr(request, "user"):  # an error before the middleware that knows the person
        return HttpResponse(_bare(heading, text), status=status)
    return render(request, "error.html", {"heading": heading, "text": text}, status=status)


def not_found(request: HttpRequest, exception: Exception) -> HttpResponse:
    """Answer 404."""
    return _page(request, 404, "There is nothing here", "The address may be wrong, or the page no longer exists.")


def forbidden(request: HttpRequest, exception: Exception) -> HttpResponse:
    """Answer 403."""
    return _page(
        request, 403, "Not for you", "Your account may not see this page. Sign in with another one, or ask staff."
    )


def bad_request(request: HttpRequest, exception: Exception) -> HttpResponse:
    """Answer 400."""
    return _page(request, 400, "That request could not be understood", "Go back, reload the page, and try once more.")


def unknown_host() -> HttpResponse:
    """Answer 400 for a Host header that is missing, doubled, or not a name of this portal."""
    text = (
        "The Host header of the request is no name of this site. Open the site by the address that you were given. "
        "Staff: ALLOWED_HOSTS lists the names."
    )
    return HttpResponse(_bare("No site of that name is here", text, ours=False), status=400)


def not_allowed(methods: Sequence[str]) -> HttpResponse:
    """Answer 405. `methods`: those that the address takes."""
    text = f"This address takes no such request, only {' or '.join(methods)}. Go back and use the links of the page."
    return HttpResponseNotAllowed(methods, _bare("That cannot be done here", text))


def too_many(request: HttpRequest) -> HttpResponse:
    """Answer 429 for attempts that are counted (`ACCOUNT_RATE_LIMITS`)."""
    return _page(
        request, 429, "That was too often",
        "Nothing was done. There is a limit on how often your account or your network address may try this; "
        "wait some minutes, then try once more.",
    )  # fmt: skip


def server_error(request: HttpRequest) -> HttpResponse:
    """Answer 500, or 503 while a store is away; drawn without using a store."""
    error = sys.exc_info()[1]
    down = isinstance(error, Error)
    heading = "A part of this site does not answer" if down else "Something broke on our side"
    told = down_text(error) if error is not None and down else "It was noted."
    text = f"{told} Nothing that was confirmed is lost. Try again in a minute."
    response = HttpResponse(_bare(heading, text), status=503 if down else 500)
    if down:
        response["Retry-After"] = "10"
    return response


def software_missing(request: HttpRequest, robot: str) -> HttpResponse:
    """Answer 503 for a robot whose package is not installed."""
    return _page(
        request, 503, f"{robot} cannot be shown now",
        "The software for this robot is not installed on this portal. Staff have to install its package. "
        "The other robots work as before.",
    )  # fmt: skip


def csrf_failure(request: HttpRequest, reason: str = "") -> HttpResponse:
    """Answer 403 for a form that is too old or comes from another site."""
    return _page(
        request, 403, "This form is out of date",
        "Nothing was done. Go back, reload the page and send the form again. Your browser must allow cookies.",
    )  # fmt: skip
