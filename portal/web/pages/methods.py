"""Refuses HTTP methods that no page uses."""

from collections.abc import Callable

from django.http import HttpRequest, HttpResponse

from portal.web.pages.errors import not_allowed

METHODS = ("GET", "HEAD", "POST", "OPTIONS", "DELETE")  # DELETE is for people's own programs


class KnownMethods:
    """Middleware that answers 405 to TRACE and other methods that no page uses, and gives each 405 its words."""

    def __init__(self, get_response: Callable[[HttpRequest], HttpResponse]) -> None:
        self._get_response = get_response

    def __call__(self, request: HttpRequest) -> HttpResponse:
        """Pass on known methods."""
        if request.method not in METHODS:
            return not_allowed(METHODS)
        answer = self._get_response(request)
        if answer.status_code == 405 and answer.has_header("Allow") and not answer.streaming and not answer.content:
            return not_allowed(answer["Allow"].split(", "))
        return answer
