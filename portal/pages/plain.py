"""Refuses texts that no database can store."""

from collections.abc import Callable

from django.core.exceptions import BadRequest, SuspiciousOperation
from django.http import HttpRequest, HttpResponse

from robots.plain import storable


class PlainText:
    """Middleware that refuses NUL and unpaired surrogates in an address, its query or a form, and too many fields."""

    def __init__(self, get_response: Callable[[HttpRequest], HttpResponse]) -> None:
        self._get_response = get_response

    def __call__(self, request: HttpRequest) -> HttpResponse:
        """Answer, or refuse with 400."""
        try:
            sent = [request.GET] if request.method in ("GET", "HEAD") else [request.GET, request.POST]
        except SuspiciousOperation as error:  # Django would log a traceback for each
            raise BadRequest("The request has too many fields, or is too large.") from error
        texts = [request.path, *(text for form in sent for key, values in form.lists() for text in (key, *values))]
        if not all(storable(text) for text in texts):
            raise BadRequest("A text contains characters that cannot be stored.")
        return self._get_response(request)
