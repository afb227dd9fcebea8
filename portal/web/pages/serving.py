"""Answers with a file, whole or in part; players of movies and readers of an index ask for parts."""

import asyncio
import re
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from functools import wraps
from pathlib import Path
from typing import Any

from django.core.handlers.asgi import ASGIRequest
from django.http import Http404, HttpResponse, HttpResponseBase, StreamingHttpResponse
from django.http.request import HttpRequest
from django.utils.translation import gettext

from portal.edge.attempts import within

PIECE = 65_536  # bytes
RANGE = re.compile(r"bytes=(\d{0,15})-(\d{0,15})\Z")
View = Callable[..., HttpResponseBase]


def plain(text: str, status: int, headers: Mapping[str, str]) -> HttpResponse:
    """Return an answer in plain text."""
    return HttpResponse(text, status=status, content_type="text/plain; charset=utf-8", headers=dict(headers))


def limit_rate(action: str = "replay") -> Callable[[View], View]:
    """Return a decorator for views, which answers 429 to a network that asks too often (`RATE_LIMITS[action]`)."""

    def decorator(view: View) -> View:
        @wraps(view)
        def answer(request: HttpRequest, *args: Any, **kwargs: Any) -> HttpResponseBase:
            if within(request, action):
                return view(request, *args, **kwargs)
            text = gettext("Too much is asked for from your network; try again in a minute.")
            return plain(f"{text}\n", 429, {"Retry-After": "60"})

        return answer

    return decorator


def file_response(request: HttpRequest, path: Path, media: str, name: str) -> HttpResponseBase:
    """Return the file, or the one range that is asked for. Raises Http404 if it is gone."""
    try:
        size = path.stat().st_size
    except OSError as error:
        raise Http404("The file is gone.") from error
    wanted = RANGE.match(request.headers.get("Range", ""))
    first, last = _span(wanted, size) if wanted else (0, size - 1)
    if first > last or first >= size:
        text = gettext("There is no such part of the file.")
        return plain(f"{text}\n", 416, {"Content-Range": f"bytes */{size}"})
    pieces = _pieces(path, first, last)
    content = read_in_threads(pieces) if isinstance(request, ASGIRequest) else pieces
    answer = StreamingHttpResponse(content, status=206 if wanted else 200, content_type=media)
    answer["Accept-Ranges"] = "bytes"
    answer["Content-Length"] = str(last - first + 1)
    answer["Content-Disposition"] = f'inline; filename="{name}"'
    if wanted:
        answer["Content-Range"] = f"bytes {first}-{last}/{size}"
    return answer


def _span(wanted: re.Match[str], size: int) -> tuple[int, int]:
    """Return the first and the last byte of a range; a range without a first byte means the last ones."""
    begin, end = wanted[1], wanted[2]
    if not begin:
        return (max(0, size - int(end)), size - 1) if end and int(end) else (size, size - 1)
    return int(begin), min(int(end), size - 1) if end else size - 1


def _pieces(path: Path, first: int, last: int) -> Iterator[bytes]:
    with path.open("rb") as file:
        file.seek(first)
        left = last - first + 1
        while left > 0 and (piece := file.read(min(PIECE, left))):
            left -= len(piece)
            yield piece


async def read_in_threads(pieces: Iterator[bytes]) -> AsyncIterator[bytes]:
    """Yield the pieces; the event loop does not wait for the disk."""
    while piece := await asyncio.to_thread(next, pieces, b""):
        yield piece
