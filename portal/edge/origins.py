"""The check of a socket's origin: only pages of this site, with the same scheme and port, may open sockets."""

import re
from typing import Any

from django.conf import settings
from django.http.request import split_domain_port, validate_host

ORIGIN = re.compile(r"(https?)://([a-z0-9.-]+|\[[0-9a-f:.]+\])(?::([0-9]{1,5}))?")
PORTS = {"http": "80", "https": "443"}
Place = tuple[str, str, str]


def place(origin: str) -> Place | None:
    """Return scheme, host and port of an origin; None for `null` and for text that is not an origin."""
    found = ORIGIN.fullmatch(origin.lower())
    return (found[1], found[2], found[3] or PORTS[found[1]]) if found else None


def headers_of(scope: dict[str, Any], name: bytes) -> list[str]:
    """Return every header of that name."""
    return [value.decode("latin-1") for key, value in scope.get("headers", []) if key == name]


def may_open(scope: dict[str, Any]) -> bool:
    """Return whether the page belongs to this site: the request's own origin, or one in the settings."""
    origins, hosts = headers_of(scope, b"origin"), headers_of(scope, b"host")
    if len(origins) != 1 or len(hosts) != 1:
        return False
    asked, scheme = place(origins[0]), "https" if scope.get("scheme") == "wss" else "http"
    domain, _ = split_domain_port(hosts[0])
    if asked is None or not domain or not validate_host(domain, settings.ALLOWED_HOSTS):
        return False
    return asked == place(f"{scheme}://{hosts[0]}") or any(_matches(asked, o) for o in settings.CSRF_TRUSTED_ORIGINS)


def _matches(asked: Place, allowed: str) -> bool:
    """Compare with one of `CSRF_TRUSTED_ORIGINS`, in which `https://*.example.org` means all its subdomains."""
    found = place(allowed.replace("://*.", "://"))
    if found is None or "://*." not in allowed:
        return asked == found
    return (asked[0], asked[2]) == (found[0], found[2]) and asked[1].endswith("." + found[1])


class Refused:
    """Answers the handshake of a socket with a status instead of opening it; `headers`: further ones."""

    def __init__(self, status: int, text: str, *headers: tuple[bytes, bytes]) -> None:
        self.status, self.text, self.headers = status, text, headers

    async def __call__(self, scope: dict[str, Any], receive: Any, send: Any) -> None:
        """Refuse."""
        if "websocket.http.response" not in (scope.get("extensions") or {}):
            await send({"type": "websocket.close"})
            return
        headers = [(b"content-type", b"text/plain; charset=utf-8"), *self.headers]
        await send({"type": "websocket.http.response.start", "status": self.status, "headers": headers})
        await send({"type": "websocket.http.response.body", "body": self.text.encode()})


class OwnOrigin:
    """Lets only pages of this site open sockets."""

    def __init__(self, app: Any) -> None:
        self.app = app
        self.refused = Refused(403, "Only pages of this site open sockets; the Origin header names another.\n")

    async def __call__(self, scope: dict[str, Any], receive: Any, send: Any) -> None:
        """Pass on, or refuse."""
        await (self.app if may_open(scope) else self.refused)(scope, receive, send)
