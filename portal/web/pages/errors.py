"""Error pages that say what was wrong and what to do.

Each is also rendered where no middleware has run, then without the menu and without a query.
"""

import sys
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any

from django.db import Error
from django.http import HttpRequest, HttpResponse, HttpResponseNotAllowed
from django.shortcuts import render
from django.template.loader import render_to_string
from django.utils.translation import get_language_from_request, gettext, override

from portal.stores import down_text
from robots.sentences import translate


def _in_their_language(view: Callable[..., HttpResponse]) -> Callable[..., HttpResponse]:
    """Answer in the language of the request, which the middleware of languages may not have seen yet."""

    @wraps(view)
    def answer(request: HttpRequest, *args: Any, **kwargs: Any) -> HttpResponse:
        with override(get_language_from_request(request)):
            return view(request, *args, **kwargs)

    return answer


def _bare(heading: str, text: str, ours: bool = True) -> str:
    """Return a page without menu; `ours`: with style and a link, which a browser asks of the host that it named."""
    return render_to_string("bare.html", {"heading": heading, "text": text, "ours": ours})


def _page(request: HttpRequest, status: int, heading: str, text: str) -> HttpResponse:
    if not hasattr(request, "user"):  # an error before the middleware that knows the person
        return HttpResponse(_bare(heading, text), status=status)
    return render(request, "error.html", {"heading": heading, "text": text}, status=status)


@_in_their_language
def not_found(request: HttpRequest, exception: Exception) -> HttpResponse:
    """Answer 404."""
    text = gettext("The address may be wrong, or the page no longer exists.")
    return _page(request, 404, gettext("There is nothing here"), text)


@_in_their_language
def forbidden(request: HttpRequest, exception: Exception) -> HttpResponse:
    """Answer 403."""
    text = gettext("Your account may not see this page. Sign in with another one, or ask staff.")
    return _page(request, 403, gettext("Not for you"), text)


@_in_their_language
def bad_request(request: HttpRequest, exception: Exception) -> HttpResponse:
    """Answer 400."""
    text = gettext("Go back, reload the page, and try once more.")
    return _page(request, 400, gettext("That request could not be understood"), text)


@_in_their_language
def unknown_host(request: HttpRequest) -> HttpResponse:
    """Answer 400 for a Host header that is missing, doubled, or not a name of this portal."""
    text = gettext(
        "The Host header of the request is no name of this site. Open the site by the address that you were given. "
        "Staff: ALLOWED_HOSTS lists the names."
    )
    return HttpResponse(_bare(gettext("No site of that name is here"), text, ours=False), status=400)


@_in_their_language
def not_allowed(request: HttpRequest, methods: Sequence[str]) -> HttpResponse:
    """Answer 405. `methods`: those that the address takes."""
    text = gettext("This address takes no such request, only {methods}. Go back and use the links of the page.")
    text = text.format(methods=gettext(" or ").join(methods))
    return HttpResponseNotAllowed(methods, _bare(gettext("That cannot be done here"), text))


@_in_their_language
def too_many(request: HttpRequest) -> HttpResponse:
    """Answer 429 for attempts that are counted (`ACCOUNT_RATE_LIMITS`)."""
    return _page(
        request, 429, gettext("That was too often"),
        gettext(
            "Nothing was done. There is a limit on how often your account or your network address may try this; "
            "wait some minutes, then try once more."
        ),
    )  # fmt: skip


@_in_their_language
def server_error(request: HttpRequest) -> HttpResponse:
    """Answer 500, or 503 while a store is away; drawn without using a store."""
    error = sys.exc_info()[1]
    down = isinstance(error, Error)
    heading = gettext("A part of this site does not answer") if down else gettext("Something broke on our side")
    told = translate(down_text(error)) if error is not None and down else gettext("It was noted.")
    text = " ".join((told, gettext("Nothing that was confirmed is lost. Try again in a minute.")))
    response = HttpResponse(_bare(heading, text), status=503 if down else 500)
    if down:
        response["Retry-After"] = "10"
    return response


@_in_their_language
def software_missing(request: HttpRequest, robot: str) -> HttpResponse:
    """Answer 503 for a robot whose package is not installed."""
    return _page(
        request, 503, gettext("{robot} cannot be shown now").format(robot=robot),
        gettext(
            "The software for this robot is not installed on this portal. Staff have to install its package. "
            "The other robots work as before."
        ),
    )  # fmt: skip


@_in_their_language
def csrf_failure(request: HttpRequest, reason: str = "") -> HttpResponse:
    """Answer 403 for a form that is too old or comes from another site."""
    return _page(
        request, 403, gettext("This form is out of date"),
        gettext("Nothing was done. Go back, reload the page and send the form again. Your browser must allow cookies."),
    )  # fmt: skip
