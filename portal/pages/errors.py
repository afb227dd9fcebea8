"""Error pages that say what was wrong and what to do."""

import sys

from django.db import Error
from django.http import HttpRequest, HttpResponse
from django.shortcuts import render
from django.template.loader import render_to_string

from portal.stores import down_text


def _page(request: HttpRequest, status: int, heading: str, text: str) -> HttpResponse:
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


def server_error(request: HttpRequest) -> HttpResponse:
    """Answer 500, or 503 while a store is away; drawn without using a store."""
    error = sys.exc_info()[1]
    down = isinstance(error, Error)
    text = down_text(error) if error is not None and down else ""
    response = HttpResponse(render_to_string("500.html", {"text": text}), status=503 if down else 500)
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
