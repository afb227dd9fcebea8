"""The index of a movie, its segment 0: all that a player needs besides the segments."""

import re
from itertools import pairwise
from typing import Annotated

import msgspec
from msgspec import Meta

from portal.broadcast.packets import SEGMENTS

LARGEST = 256 * 1024  # bytes
HOUR_MS = 3_600_000
TITLE = 200  # characters
NO_TITLE = re.compile(r'["\x00-\x1f\x7f]')

Times = Annotated[list[Annotated[int, Meta(ge=0, le=HOUR_MS)]], Meta(min_length=1, max_length=SEGMENTS - 1)]


class Index(msgspec.Struct, frozen=True):
    """The times of each segment: `starts_ms` and `durations_ms` of the segments 1, 2 and so on.

    `codec` is the name of RFC 6381, as browsers are asked for it; `init` the initialization segment of ISO BMFF;
    `independent`: each segment begins with a key picture; `title`: where and when it was taken, may be empty.
    """

    codec: Annotated[str, Meta(max_length=40, pattern="^[A-Za-z0-9.]+$")]
    init: Annotated[bytes, Meta(min_length=1, max_length=64 * 1024)]
    starts_ms: Times
    durations_ms: Times
    independent: bool
    title: Annotated[str, Meta(max_length=TITLE, pattern=r'^[^"\x00-\x1f\x7f]*$')] = ""


def as_title(text: str) -> str:
    """Return a text as a title: without what a playlist cannot quote, and as long as a title may be."""
    return NO_TITLE.sub("", text)[:TITLE]


def encode(index: Index) -> bytes:
    """Return the index as it is broadcast."""
    return msgspec.msgpack.encode(index)


def decode(data: bytes) -> Index:
    """Return the index. Raises ValueError if it is too long or its times are out of order or do not fit."""
    if len(data) > LARGEST:
        raise ValueError("An index of a movie is not that long.")
    index = msgspec.msgpack.decode(data, type=Index)  # its errors are ValueErrors
    starts = index.starts_ms
    if len(starts) != len(index.durations_ms) or any(later <= earlier for earlier, later in pairwise(starts)):
        raise ValueError("The times of a movie's segments do not fit.")
    return index
