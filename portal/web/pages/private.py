"""Keeps personal pages out of all caches."""

from collections.abc import Callable

from django.conf import settings
from django.http import HttpRequest, HttpResponse
from django.utils.cache import add_never_cache_headers

OWN = ("/accounts/", "/admin/", "/me/")


class PrivatePages:
    """Middleware that sets `no-store` on answers to signed-in people, unless the view sets its own rule."""

    def __init__(self, get_response: Callable[[HttpRequest], HttpResponse]) -> None:
        self._get_response = get_response

    def __call__(self, request: HttpRequest) -> HttpResponse:
        """Answer with `no-store`."""
        answer = self._get_response(request)
        private = settings.SESSION_COOKIE_NAME in request.COOKIES or request.path.startswith(OWN)
        if private and not answer.has_header("Cache-Control"):
            add_never_cache_headers(answer)
        return answer
