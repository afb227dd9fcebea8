"""Refuses requests for other hosts before anything else sees them."""

import logging
from collections.abc import Callable

from django.core.exceptions import DisallowedHost
from django.http import HttpRequest, HttpResponse

from portal.logs.security import address_of
from portal.web.pages.errors import unknown_host

log = logging.getLogger("farhand.security")
SHOWN = 80  # characters


class KnownHost:
    """Middleware that answers 400 where the Host header is not in `ALLOWED_HOSTS`, doubled, or no host.

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
            log.warning("refused with 400: Host %r from %s", host, address_of(request))
            return unknown_host()
        return self._get_response(request)
