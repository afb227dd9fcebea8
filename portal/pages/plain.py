"""Texts that no store can keep are refused at the door, with a sentence."""

from collections.abc import Callable

from django.core.exceptions import BadRequest
from django.http import HttpRequest, HttpResponse

from robots.plain import storable


class PlainText:
    """Middleware: no NUL and no half characters in an address, its query or a form."""

    def __init__(self, get_response: Callable[[HttpRequest], HttpResponse]) -> None:
        self._get_response = get_response

    def __call__(self, request: HttpRequest) -> HttpResponse:
        """Answer, or 400."""
        sent = [request.GET] if request.method in ("GET", "HEAD") else [request.GET, request.POST]
        texts = [request.path, *(text for form in sent for key, values in form.lists() for text in (key, *values))]
        if not all(storable(text) for text in texts):
            raise BadRequest("A text holds characters that cannot be kept.")
        return self._get_response(request)
