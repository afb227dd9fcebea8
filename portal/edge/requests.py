"""Limits of requests and sockets before anything is stored: size, time, and number at once."""

import asyncio
from typing import Any

from django.conf import settings
from django.http import HttpRequest
from django.utils.translation import get_language_from_request, gettext, gettext_noop, override

from portal.edge.dropped import drop
from portal.edge.limits import AddressCount
from portal.edge.origins import Refused, headers_of

TOO_LARGE = gettext_noop("The request is too large.")
TOO_SLOW = gettext_noop("The request did not arrive in time.")
TOO_MANY = gettext_noop("Too many requests from your network address at once; wait a moment.")
TOO_MANY_SOCKETS = "Too many sockets from your network address.\n"
STAFF_PATH = "/admin/"
OPERATORS_PATH = "/ws/operators/"  # counted apart: a viewer takes no place from an operator


class _Refused(Exception):
    def __init__(self, status: int, text: str) -> None:
        super().__init__(text)
        self.status, self.text = status, text


def bounds_of(path: str) -> tuple[int, float]:
    """Return the largest body at this path (bytes) and the longest time for it (s)."""
    if path.startswith(STAFF_PATH):
        return settings.LIMITS["STAFF_BODY"], settings.LIMITS["STAFF_BODY_S"]
    return settings.LIMITS["BODY"], settings.LIMITS["BODY_S"]


def _translated(text: str, scope: dict[str, Any]) -> str:
    """Return the text in the first language of the browser that we have; no cookie is read here."""
    request = HttpRequest()
    request.META["HTTP_ACCEPT_LANGUAGE"] = ",".join(headers_of(scope, b"accept-language"))
    with override(get_language_from_request(request)):
        return gettext(text)


async def refuse(scope: dict[str, Any], send: Any, status: int, text: str) -> None:
    """Answer with a sentence and end the connection; the rest of the request is not read."""
    body = _translated(text, scope).encode() + b"\n"
    headers = [
        (b"content-type", b"text/plain; charset=utf-8"), (b"content-length", b"%d" % len(body)),
        (b"connection", b"close"), (b"retry-after", b"5"),
    ]  # fmt: skip
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})


class Bounded:
    """ASGI middleware that applies the limits to the whole application."""

    def __init__(self, app: Any) -> None:
        self.app = app
        self._requests = AddressCount(settings.LIMITS["REQUESTS"])
        self._sockets = AddressCount(settings.LIMITS["SOCKETS"])
        self._operators = AddressCount(settings.LIMITS["OPERATORS"])
        self._refused = Refused(429, TOO_MANY_SOCKETS, (b"retry-after", b"30"))

    async def __call__(self, scope: dict[str, Any], receive: Any, send: Any) -> None:
        """Pass on requests within the limits."""
        address = (scope.get("client") or ("", 0))[0]
        if scope["type"] == "websocket":
            sockets = self._operators if scope["path"].startswith(OPERATORS_PATH) else self._sockets
            with sockets.one(address) as entered:
                if entered:
                    await self.app(scope, receive, send)
                else:
                    drop("of an address that has enough")
                    await self._refused(scope, receive, send)
        elif scope["type"] == "http":
            with self._requests.one(address) as entered:
                if entered:
                    await self._request(scope, receive, send)
                else:
                    await refuse(scope, send, 429, TOO_MANY)
        else:
            await self.app(scope, receive, send)

    async def _request(self, scope: dict[str, Any], receive: Any, send: Any) -> None:
        most, seconds = bounds_of(scope["path"])
        body, started = _Body(receive, most, seconds), False

        async def send_noted(message: dict[str, Any]) -> None:
            nonlocal started
            started = True
            await send(message)

        try:
            body.check_length(scope["headers"])
            await self.app(scope, body.receive, send_noted)
        except _Refused as error:
            if not started:
                await refuse(scope, send, error.status, error.text)


class _Body:
    def __init__(self, receive: Any, most: int, seconds: float) -> None:
        self._receive, self._left, self._whole = receive, most, False
        self._until = asyncio.get_running_loop().time() + seconds

    def check_length(self, headers: list[tuple[bytes, bytes]]) -> None:
        """Refuse a request whose declared length is too large. Raises _Refused."""
        for name, value in headers:
            if name == b"content-length" and (not value.isdigit() or len(value) > 15 or int(value) > self._left):
                raise _Refused(413, TOO_LARGE)

    async def receive(self) -> Any:
        """Return the next part. Raises _Refused if it is too large or too late."""
        if self._whole:
            return await self._receive()  # waits until the connection ends
        try:
            async with asyncio.timeout_at(self._until):
                message = await self._receive()
        except TimeoutError:
            raise _Refused(408, TOO_SLOW) from None
        self._left -= len(message.get("body", b""))
        if self._left < 0:
            raise _Refused(413, TOO_LARGE)
        self._whole = not message.get("more_body", False)
        return message
