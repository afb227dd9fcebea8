"""Repairs by HTTP: the origin answers ranges of segments, an edge fetches them and checks their tag."""

import asyncio
import hmac
import http.client
import re
from collections.abc import Callable
from io import BytesIO
from urllib.parse import urlsplit

from portal.broadcast import packets
from portal.broadcast.answers import Answer, Headers, as_json, later, nothing
from portal.broadcast.assembly import Gap
from portal.broadcast.carousel import Carousel
from portal.broadcast.edge import LONGEST
from portal.broadcast.timetable import SECOND

PLACE = re.compile(r"/([0-9a-f]{8})/([0-9]{1,4})")
RANGE = re.compile(r"bytes=([0-9]{1,8})-([0-9]{1,8})")
CONTENT_RANGE = re.compile(r"bytes ([0-9]{1,8})-([0-9]{1,8})/([0-9]{1,8})")
STATUS, LENGTH = re.compile(rb"HTTP/1\.[01] ([1-5][0-9]{2})\b"), re.compile("[0-9]{1,7}")
HEAD = 16 * 1024  # bytes of an answer's headers
TAG = "farhand-tag"
TIMEOUT_S = 2.0
SAVED_S = 5  # the token bucket holds what comes in so long


class Repairs:
    """Answers edges from the contents of the carousel, at most `rate` bytes a second."""

    def __init__(self, carousel: Carousel, key: bytes, rate: float, now_ns: Callable[[], int]) -> None:
        self._carousel, self._key, self._rate, self._now_ns = carousel, key, rate, now_ns
        self._room, self._at_ns = rate * SAVED_S, now_ns()
        self.bytes_sent = self.request_count = 0  # bytes and requests

    def answer(self, path: str, headers: Headers) -> Answer:
        """Answer a request for a range of a segment."""
        if path == "/status.json":
            return as_json(self._status())
        place, wanted = PLACE.fullmatch(path), RANGE.fullmatch(headers.get("range", ""))
        if place is None or int(place[1], 16) != self._carousel.movie:
            return nothing()
        number = int(place[2])
        if number >= len(self._carousel.contents):
            return nothing()
        content = self._carousel.contents[number]
        begin, last = (int(wanted[1]), int(wanted[2])) if wanted else (0, LONGEST - 1)
        end = min(last + 1, begin + LONGEST, len(content))
        if begin >= end:
            return Answer(416, b"", {"content-range": f"bytes */{len(content)}"})
        if not self._allowed(end - begin):
            return later(1)
        data = content[begin:end]
        self.request_count, self.bytes_sent = self.request_count + 1, self.bytes_sent + len(data)
        told = packets.range_tag(self._key, self._carousel.movie, number, begin, len(content), data)
        head = {"content-range": f"bytes {begin}-{end - 1}/{len(content)}", "content-type": "application/octet-stream"}
        return Answer(206, data, {**head, "cache-control": "no-store", TAG: told})

    def _status(self) -> dict[str, object]:
        sent = self._carousel
        return {
            "movie": f"{sent.movie:08x}", "packets": sent.packets, "bytes": sent.bytes, "pauses": sent.skipped,
            "late_ms": sent.late_ns // 10**6,
            "repairs": self.request_count, "repaired_bytes": self.bytes_sent,
        }  # fmt: skip

    def _allowed(self, size: int) -> bool:
        now = self._now_ns()
        self._room = min(self._rate * SAVED_S, self._room + self._rate * (now - self._at_ns) / SECOND)
        self._at_ns = now
        if self._room <= 0:
            return False
        self._room -= size
        return True


def verify(key: bytes, movie: int, gap: Gap, answer: Answer) -> tuple[bytes, int] | None:
    """Return the bytes of an answer and the size of its segment; None if the answer does not fit the gap or its tag."""
    place = CONTENT_RANGE.fullmatch(answer.headers.get("content-range", ""))
    if answer.status != 206 or place is None:
        return None
    begin, last, size = (int(number) for number in place.groups())
    told = packets.range_tag(key, movie, gap.segment, begin, size, answer.body)
    if begin != gap.begin or last + 1 - begin != len(answer.body) or last >= size or size > packets.LARGEST:
        return None
    fits = hmac.compare_digest(told.encode(), answer.headers.get(TAG, "").encode())
    return (answer.body, size) if fits else None


def path_of(movie: int, gap: Gap) -> str:
    """Return the path at the origin of the segment that has a gap."""
    return f"/{movie:08x}/{gap.segment}"


def range_of(gap: Gap) -> str:
    """Return the value of the header `Range` that asks for a gap."""
    return f"bytes={gap.begin}-{(gap.begin + LONGEST if gap.all else gap.end) - 1}"


async def fetch(origin: str, movie: int, gap: Gap) -> Answer | None:
    """Ask the origin (`http://host:port`) for a gap. Return its answer; None if none came in time."""
    try:
        address = urlsplit(origin)
        tls = address.scheme == "https"
        async with asyncio.timeout(TIMEOUT_S):
            reader, writer = await asyncio.open_connection(
                address.hostname, address.port or (443 if tls else 80), ssl=tls or None, limit=HEAD
            )
            try:
                writer.write(
                    f"GET {address.path.rstrip('/')}{path_of(movie, gap)} HTTP/1.1\r\nHost: {address.netloc}\r\n"
                    f"Range: {range_of(gap)}\r\nConnection: close\r\n\r\n".encode()
                )
                return await _read(reader)
            finally:
                writer.transport.abort()  # nobody waits for an orderly close
    except (OSError, EOFError, TimeoutError, ValueError, asyncio.LimitOverrunError, http.client.HTTPException):
        return None


async def _read(reader: asyncio.StreamReader) -> Answer | None:
    head = await reader.readuntil(b"\r\n\r\n")
    line, _, rest = head.partition(b"\r\n")
    status = STATUS.match(line)
    headers = {name.lower(): value for name, value in http.client.parse_headers(BytesIO(rest)).items()}
    length = headers.get("content-length", "")
    if status is None or not LENGTH.fullmatch(length) or int(length) > LONGEST:
        return None
    return Answer(int(status[1]), await reader.readexactly(int(length)), headers)
