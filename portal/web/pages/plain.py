"""Refuses texts that no database can store, and filters that it cannot compare."""

import logging
from collections.abc import Callable

from django.core.exceptions import BadRequest, SuspiciousOperation
from django.db import DataError, NotSupportedError, ProgrammingError
from django.http import HttpRequest, HttpResponse

from portal.web.pages.errors import bad_request
from robots.kit.plain import plain_breaks, storable

log = logging.getLogger(__name__)
# of a filter in the address of a list: a number too great, a year that is none, half a range, no pattern
WRONG = (ArithmeticError, LookupError, TypeError, ValueError, DataError, NotSupportedError, ProgrammingError)


def _break_plainly(request: HttpRequest) -> None:
    form = request.POST.copy()
    for name, values in request.POST.lists():
        form.setlist(name, [plain_breaks(value) for value in values])
    form._mutable = False
    request.POST = form  # type: ignore[assignment] # a QueryDict, as before


class PlainText:
    """Middleware that refuses NUL and unpaired surrogates in an address, its query or a form, and too many fields.

    What a form sends has line breaks of one character from here on, so that no text is longer than its field showed.
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

        The exception is logged, because it may be a fault of ours. That of an action is one: it is answered with 500.
        """
        match = request.resolver_match
        listed = match is not None and match.namespace == "admin" and str(match.url_name).endswith("_changelist")
        looked = request.method in ("GET", "HEAD") and request.GET
        if not (listed and looked and isinstance(exception, WRONG)):
            return None
        log.warning("the list %s failed at its filters", request.path, exc_info=exception)
        return bad_request(request, exception)
