"""HTTP answers of origin and edges; `application` makes an ASGI application of either."""

import json
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

LONGEST_PATH = 100  # characters
Headers = Mapping[str, str]


@dataclass(frozen=True)
class Answer:
    """An answer of HTTP."""

    status: int
    body: bytes = b""
    headers: Headers = field(default_factory=dict)


Answering = Callable[[str, Headers], Answer]  # by path, and the request's headers in small letters
Application = Callable[
    [dict[str, Any], Callable[[], Awaitable[Any]], Callable[[Any], Awaitable[None]]], Awaitable[None]
]


def text(body: str, kind: str, cache: str) -> Answer:
    """Return an answer of the media type `kind` with the header `Cache-Control: <cache>`."""
    return Answer(200, body.encode(), {"content-type": kind, "cache-control": cache})


def later(seconds: int) -> Answer:
    """Return that it is too early or asked too often (503), and after how many seconds to ask again."""
    return Answer(503, b"", {"retry-after": str(seconds), "cache-control": "no-store"})


def as_json(value: object) -> Answer:
    """Return an answer of JSON that no cache keeps."""
    return text(json.dumps(value), "application/json", "no-store")


def nothing() -> Answer:
    """Return that there is nothing at this address (404); caches keep it for a second, because something may come."""
    return Answer(404, b"", {"cache-control": "max-age=1"})


def application(answering: Answering) -> Application:
    """Return an ASGI application that answers GET and HEAD, whose bodies it does not read."""

    async def answer_request(
        scope: dict[str, Any], _: Callable[[], Awaitable[Any]], send: Callable[[Any], Awaitable[None]]
    ) -> None:
        if scope["type"] != "http":
            await send({"type": "websocket.close"})
            return
        if scope["method"] not in ("GET", "HEAD"):
            answer = Answer(405, b"", {"allow": "GET, HEAD"})
        elif len(scope["path"]) > LONGEST_PATH:
            answer = nothing()
        else:
            headers = {name.decode("latin-1"): value.decode("latin-1") for name, value in scope["headers"]}
            answer = answering(scope["path"], headers)
        told = {
            "content-length": str(len(answer.body)), "access-control-allow-origin": "*",
            "x-content-type-options": "nosniff", **answer.headers,
        }  # fmt: skip
        raw = [(name.encode(), value.encode()) for name, value in told.items()]
        await send({"type": "http.response.start", "status": answer.status, "headers": raw})
        await send({"type": "http.response.body", "body": b"" if scope["method"] == "HEAD" else answer.body})

    return answer_request
