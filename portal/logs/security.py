"""The security log: sign-ins, failed sign-ins, sign-outs, and refused requests.

It contains no password, session key or token, and no typed name, because people type passwords there.
"""

import logging
from collections.abc import Callable
from typing import Any

from django.contrib.auth import signals
from django.http import HttpRequest, HttpResponse

log = logging.getLogger("farhand.security")
REFUSED = (401, 403, 429)


def listen() -> None:
    """Connect Django's signals of signing in and out."""
    signals.user_logged_in.connect(_signed_in, dispatch_uid="security log")
    signals.user_logged_out.connect(_signed_out, dispatch_uid="security log")
    signals.user_login_failed.connect(_failed, dispatch_uid="security log")


def address_of(request: HttpRequest | None) -> str:
    """Return the network address of the request; empty without a request."""
    return str(request.META.get("REMOTE_ADDR", "")) if request is not None else ""


def _signed_in(request: HttpRequest | None = None, user: Any = None, **_: Any) -> None:
    log.info("signed in: account %s from %s", getattr(user, "pk", None), address_of(request))


def _signed_out(request: HttpRequest | None = None, user: Any = None, **_: Any) -> None:
    if user is not None:
        log.info("signed out: account %s from %s", user.pk, address_of(request))


def _failed(request: HttpRequest | None = None, **_: Any) -> None:
    log.warning("sign-in failed from %s", address_of(request))


class RefusalLog:
    """Middleware that logs requests refused for a missing permission, or for coming too often."""

    def __init__(self, get_response: Callable[[HttpRequest], HttpResponse]) -> None:
        self._get_response = get_response

    def __call__(self, request: HttpRequest) -> HttpResponse:
        """Answer, then log a refusal."""
        answer = self._get_response(request)
        if answer.status_code in REFUSED:
            who = getattr(getattr(request, "user", None), "pk", None)
            log.warning(
                "refused with %d: %s %s, account %s from %s",
                answer.status_code, request.method, request.path, who, address_of(request),
            )  # fmt: skip
        return answer
