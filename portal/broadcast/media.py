"""Cuts an MP4 file into the initialization segment and the media segments that are broadcast (fragmented MP4).

Nothing is coded again: a segment has the pictures that are decoded within one slot, whether or not it begins with a key
picture. Players that begin at the beginning and go on show it as it was; only to jump needs key pictures.
"""

import math
from dataclasses import dataclass
from fractions import Fraction
from io import BytesIO
from pathlib import Path
from typing import Any

from portal.broadcast import index
from portal.broadcast.packets import LARGEST, SEGMENTS
from portal.broadcast.timetable import SECOND

MOST = 256 * 1024 * 1024  # bytes of a movie
FRAGMENT = {
    "movflags": "empty_moov+default_base_moof+frag_discont+skip_trailer", "use_editlist": "0",
    "avoid_negative_ts": "disabled", "video_track_timescale": "90000",
}  # fmt: skip
BOX = 8  # bytes of the head of a box: its length and its name
NO_MOVIE = "It is no movie that can be broadcast: "


class NoMovie(ValueError):
    """The file cannot be broadcast; the text says why."""


@dataclass(frozen=True)
class Movie:
    """A movie as it is broadcast: its segments, of which the first one is the index, and when each is shown."""

    index: index.Index
    contents: tuple[bytes, ...]
    starts_ns: tuple[int, ...]

    @property
    def seconds(self) -> float:
        """Return its length (s)."""
        return (self.index.starts_ms[-1] + self.index.durations_ms[-1]) / 1000

    @property
    def rate(self) -> float:
        """Return the bytes a second while it is shown, the b of the papers."""
        return sum(map(len, self.contents[1:])) / self.seconds


def box_places(data: bytes) -> list[tuple[bytes, int, int]]:
    """Return the boxes of ISO BMFF: name, where each begins and ends. Raises NoMovie."""
    found, at = [], 0
    while at < len(data):
        length = int.from_bytes(data[at : at + 4], "big")
        if length < BOX or at + length > len(data):
            raise NoMovie(NO_MOVIE + "a box of it is broken.")
        found.append((data[at + 4 : at + BOX], at, at + length))
        at += length
    return found


def _fragment(template: Any, pictures: list[Any], number: int, shift: int) -> tuple[bytes, bytes]:
    """Return the initialization segment and the media segment of these packets."""
    from av import open as opened  # noqa: PLC0415 - only here

    out = BytesIO()
    with opened(out, "w", format="mp4", options={**FRAGMENT, "fragment_index": str(number)}) as made:
        stream = made.add_stream_from_template(template)
        for picture in pictures:
            picture.stream = stream
            picture.dts, picture.pts = picture.dts - shift, picture.pts - shift
            made.mux(picture)
    data = out.getvalue()
    media = min((begin for name, begin, _ in box_places(data) if name == b"moof"), default=len(data))
    return data[:media], data[media:]


def _codec(stream: Any) -> str:
    """Return RFC 6381's name. Raises NoMovie where browsers do not show it everywhere."""
    extra = bytes(stream.codec_context.extradata or b"")
    if stream.codec_context.name != "h264" or len(extra) < 4:
        raise NoMovie(NO_MOVIE + "its pictures are not H.264.")
    return f"avc1.{extra[1:4].hex()}"


def _slots(file: Any, stream: Any, slot_ms: int) -> list[list[Any]]:
    """Return the packets of each slot in which a picture is decoded. Raises NoMovie."""
    slots: list[list[Any]] = []
    current, total, first = -1, 0, None
    for picture in file.demux(stream):
        if picture.dts is None or picture.pts is None:
            continue
        first = picture.dts if first is None else first
        slot = int((picture.dts - first) * stream.time_base * 1000) // slot_ms
        total += picture.size
        if slot < current or total > MOST or slot * slot_ms > index.HOUR_MS:
            raise NoMovie(NO_MOVIE + f"it is longer than an hour, larger than {MOST} bytes, or out of order.")
        if slot > current:
            slots.append([])
            current = slot
        slots[-1].append(picture)
    if not 0 < len(slots) < SEGMENTS:
        raise NoMovie(NO_MOVIE + "it has no pictures, or more segments than are sent.")
    return slots


def cut(path: Path, slot_ms: int, title: str = "") -> Movie:
    """Return the movie of a file, cut into slots of `slot_ms` milliseconds. Raises NoMovie, OSError."""
    from av import FFmpegError  # noqa: PLC0415 - only here
    from av import open as opened  # noqa: PLC0415

    try:
        with opened(str(path), format="mp4") as file:
            if not file.streams.video:
                raise NoMovie(NO_MOVIE + "it has no pictures.")
            stream = file.streams.video[0]
            codec, slots = _codec(stream), _slots(file, stream, slot_ms)
            ticks, last = 1000 * Fraction(stream.time_base or 1), slots[-1][-1]
            first = slots[0][0].dts
            starts = [int((slot[0].dts - first) * ticks) for slot in slots]
            ends = [*starts[1:], math.ceil((last.dts - first + max(last.duration or 0, 1)) * ticks)]
            independent = all(slot[0].is_keyframe for slot in slots)
            pieces = [_fragment(stream, slot, number + 1, first) for number, slot in enumerate(slots)]
    except FileNotFoundError:
        raise
    except FFmpegError as error:
        raise NoMovie(NO_MOVIE + str(error)) from error
    durations = [end - start for start, end in zip(starts, ends, strict=True)]
    made = index.Index(codec, pieces[0][0], starts, durations, independent, index.as_title(title))
    contents = (index.encode(made), *(media for _, media in pieces))
    if max(map(len, contents)) > LARGEST or len(contents[0]) > index.LARGEST:
        raise NoMovie(NO_MOVIE + "a segment of it is too large.")
    return Movie(made, contents, (0, *(start * SECOND // 1000 for start in starts)))
