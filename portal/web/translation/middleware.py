"""The language and the time zone of the person who reads."""

from collections.abc import Callable
from functools import cache
from zoneinfo import ZoneInfo, available_timezones

from django.conf import settings
from django.http import HttpRequest, HttpResponse
from django.http.response import HttpResponseBase
from django.middleware.locale import LocaleMiddleware
from django.utils import timezone
from django.utils.cache import patch_vary_headers

SHARED = "/embed/"  # pages in frames of other sites, which caches give to everybody: no cookie counts
ZONE_COOKIE = "zone"  # the name of the browser's time zone, which a script of every page writes


class ReaderLanguage(LocaleMiddleware):
    """Middleware that chooses the language: the person's choice, else the first of the browser that we have."""

    def process_request(self, request: HttpRequest) -> None:
        """Choose the language."""
        if request.path.startswith(SHARED):
            for name in (settings.LANGUAGE_COOKIE_NAME, ZONE_COOKIE):
                request.COOKIES.pop(name, None)
        super().process_request(request)

    def process_response(self, request: HttpRequest, response: HttpResponseBase) -> HttpResponseBase:
        """Tell caches that a page differs with language and zone; pictures and data are the same for everybody."""
        if not response.get("Content-Type", "").startswith("text/html"):
            return response
        answer = super().process_response(request, response)
        if not request.path.startswith(SHARED):
            patch_vary_headers(answer, ["Cookie"])
        return answer


class ReaderZone:
    """Middleware that shows times in the zone of the browser; in UTC until a browser has named a zone that exists."""

    def __init__(self, get_response: Callable[[HttpRequest], HttpResponse]) -> None:
        self._get_response = get_response

    def __call__(self, request: HttpRequest) -> HttpResponse:
        """Answer with that zone active."""
        with timezone.override(zone_of(request.COOKIES.get(ZONE_COOKIE, ""))):
            return self._get_response(request)


def zone_of(name: str) -> ZoneInfo | None:
    """Return the time zone of that name; None if there is none."""
    return ZoneInfo(name) if name in _zones() else None


@cache
def _zones() -> set[str]:
    return available_timezones()
