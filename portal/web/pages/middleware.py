"""Middleware: refuses requests that no page should see, serves static files, and keeps private pages out of caches."""

import logging
from collections.abc import Callable
from typing import Any
from wsgiref.headers import Headers

from django.conf import settings
from django.core.exceptions import BadRequest, DisallowedHost, SuspiciousOperation
from django.core.handlers.asgi import ASGIRequest
from django.db import DataError, NotSupportedError, ProgrammingError
from django.http import HttpRequest, HttpResponse
from django.utils.cache import add_never_cache_headers
from whitenoise.middleware import WhiteNoiseMiddleware

from portal.logs.security import address_of
from portal.web.pages.errors import bad_request, not_allowed, unknown_host
from portal.web.pages.serving import PIECE, read_in_threads
from robots.kit.plain import plain_breaks, storable

log, security = logging.getLogger(__name__), logging.getLogger("farhand.security")
SHOWN = 80  # characters of a Host header
METHODS = ("GET", "HEAD", "POST", "OPTIONS", "DELETE")  # DELETE is for people's own programs
DEVICES = ", ".join(
    (*(f"{name}=(self)" for name in ("accelerometer", "gamepad", "gyroscope", "hid")),
     *(f"{name}=()" for name in ("camera", "geolocation", "microphone", "serial", "usb")))
)  # fmt: skip
OWN = ("/accounts/", "/admin/", "/me/")  # pages of one person
STABLE = ("/static/farhand/", "/static/robots/")  # addresses of files that may change
# errors of a filter in the address of a list: too great a number, an impossible year, half a range, no pattern
WRONG = (ArithmeticError, LookupError, TypeError, ValueError, DataError, NotSupportedError, ProgrammingError)


class KnownHost:
    """Middleware that answers 400 if the Host header is not in `ALLOWED_HOSTS`, doubled, or no host.

    Django would refuse it where the host is first used, with a traceback in the log for each request.
    """

    def __init__(self, get_response: Callable[[HttpRequest], HttpResponse]) -> None:
        self._get_response = get_response

    def __call__(self, request: HttpRequest) -> HttpResponse:
        """Pass on requests for this portal."""
        try:
            request.get_host()
        except DisallowedHost:
            host = str(request.META.get("HTTP_HOST", ""))[:SHOWN]
            security.warning("refused with 400: Host %r from %s", host, address_of(request))
            return unknown_host(request)
        return self._get_response(request)


class Devices:
    """Middleware that tells browsers which devices pages may use: those with which a person moves a robot."""

    def __init__(self, get_response: Callable[[HttpRequest], HttpResponse]) -> None:
        self._get_response = get_response

    def __call__(self, request: HttpRequest) -> HttpResponse:
        """Add the header `Permissions-Policy`."""
        answer = self._get_response(request)
        answer["Permissions-Policy"] = DEVICES
        return answer


class KnownMethods:
    """Middleware that answers 405 to TRACE and other methods that no page uses, and adds a text to each empty 405."""

    def __init__(self, get_response: Callable[[HttpRequest], HttpResponse]) -> None:
        self._get_response = get_response

    def __call__(self, request: HttpRequest) -> HttpResponse:
        """Pass on known methods."""
        if request.method not in METHODS:
            return not_allowed(request, METHODS)
        answer = self._get_response(request)
        if answer.status_code == 405 and answer.has_header("Allow") and not answer.streaming and not answer.content:
            return not_allowed(request, answer["Allow"].split(", "))
        return answer


def _break_plainly(request: HttpRequest) -> None:
    form = request.POST.copy()
    for name, values in request.POST.lists():
        form.setlist(name, [plain_breaks(value) for value in values])
    form._mutable = False
    request.POST = form  # type: ignore[assignment] # a QueryDict, as before


class PlainText:
    """Middleware that refuses NUL and unpaired surrogates in an address, its query or a form, and too many fields.

    From here on, line breaks of a form are one character, so that no text is longer than its field showed.
    """

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
        if request.path.startswith("/admin/") and any("regex" in name for name in request.GET):
            raise BadRequest("A list is not filtered by patterns, which can take for ever.")
        if any("\r" in text for text in texts):
            _break_plainly(request)
        return self._get_response(request)

    def process_exception(self, request: HttpRequest, exception: Exception) -> HttpResponse | None:
        """Answer 400 where a list of the admin fails at its filters; Django lets some through to the database.

        The exception is logged, because it may be a fault of ours. An exception of an action is one: the answer is 500.
        """
        match = request.resolver_match
        listed = match is not None and match.namespace == "admin" and str(match.url_name).endswith("_changelist")
        looked = request.method in ("GET", "HEAD") and request.GET
        if not (listed and looked and isinstance(exception, WRONG)):
            return None
        log.warning("the list %s failed at its filters", request.path, exc_info=exception)
        return bad_request(request, exception)


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


class StaticFiles(WhiteNoiseMiddleware):
    """WhiteNoise, whose own answers are read into memory whole under ASGI; these are sent in pieces."""

    def add_cache_headers(self, headers: Headers, path: str, url: str) -> None:
        """Add `Cache-Control`; a file at a stable address is asked for again at each load of a page."""
        super().add_cache_headers(headers, path, url)
        if url.startswith(STABLE):
            headers["Cache-Control"] = "no-cache"

    @staticmethod
    def serve(static_file: Any, request: HttpRequest) -> Any:
        """Return the answer with the file."""
        answer = WhiteNoiseMiddleware.serve(static_file, request)
        if isinstance(request, ASGIRequest):
            answer.block_size = PIECE
            answer.streaming_content = read_in_threads(iter(answer.streaming_content))
        return answer
