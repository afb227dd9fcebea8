"""The content of a recording over time: an index, and slices of a few seconds that can be replayed one by one.

A slice holds the packets of the live path, so that a console decodes them as it always does. No Django.
"""

import struct
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from robots.kit.contract.streams import unpack
from robots.kit.recording import reading
from robots.kit.recording.axis import Axis, words_of
from robots.kit.recording.container import (
    CAMERA,
    COMMANDS,
    EVENTS,
    STATE,
    STREAM,
    Message,
    camera_of,
    jpeg_of,
    nameless,
)
from robots.kit.recording.packets import picture_packed, state_packed

SLICE_MS = 5000
HEAD = struct.Struct("<II")  # of each packet in a slice: its length, ms since the beginning of the recording
MS = 10**6  # ns
MOST = 24 * 3600 * 1000 // SLICE_MS  # slices
TOO_LONG = "It is longer than a day; no more of it is shown."
Place = tuple[int, int | None, int]  # a chunk's offset, and the axis before it: newest time and its place (ns)


@dataclass
class Index:
    """When a recording begins (ms since 1970) and ends, as the player counts the time, and what is in it.

    `needs` names for each slice the earliest slice that has to be read to know everything at its beginning: the last
    state, the last picture of each camera, and each byte stream since its last key packet. `end`: in words, why it
    ends where it does, if its file is not whole. `places`: for each slice, where the file is read from. `topics`: of
    the file's channels.
    """

    began_ms: int = 0
    ended_ms: int = 0
    end: str = ""
    needs: list[int] = field(default_factory=list)
    cameras: list[int] = field(default_factory=list)
    pictures: int = 0
    commands: list[dict[str, Any]] = field(default_factory=list)
    events: list[dict[str, Any]] = field(default_factory=list)
    places: list[Place] = field(default_factory=list)
    topics: dict[int, str] = field(default_factory=dict)


def slice_of(at_ms: int) -> int:
    """Return the slice that holds a time (ms since the beginning)."""
    return max(0, at_ms) // SLICE_MS


def needed_slices(starts: Iterable[Sequence[int]], slices: int) -> list[int]:
    """Return the earliest slice that each slice needs. `starts`: of each channel, when something begins anew (ms)."""
    tracks = [sorted(times) for times in starts]
    found = []
    for number in range(slices):
        needs = number
        for times in tracks:
            before = bisect_right(times, number * SLICE_MS)
            if before:
                needs = min(needs, slice_of(times[before - 1]))
        found.append(needs)
    return found


def read_index(path: Path) -> Index:
    """Return the index of a file, of as much of it as can be read. Raises OSError."""
    index, starts, axis, at_ms = Index(), dict[str, list[int]](), Axis(), 0
    end = ""
    for part in reading.parts(path, 0, index.topics):
        place = part.offset, axis.newest_ns, axis.at_ns
        for message in part.messages:
            index.began_ms = index.began_ms or message.at_ns // MS
            at_ms = axis.place(message.at_ns) // MS
            if slice_of(at_ms) >= MOST:
                return _ended(index, starts, MOST * SLICE_MS - 1, TOO_LONG)
            index.places += [place] * (slice_of(at_ms) + 1 - len(index.places))
            if axis.set_ns:
                index.events.append(_event(at_ms, words_of(axis.set_ns)))
            if _begins_anew(message):
                starts.setdefault(message.topic, []).append(at_ms)
            _note(index, message, at_ms)
        end = part.fault or ("" if part.messages else end)
        if part.fault:
            index.events.append(_event(at_ms, part.fault))
    return _ended(index, starts, at_ms, end)


def _ended(index: Index, starts: dict[str, list[int]], at_ms: int, end: str) -> Index:
    index.ended_ms = index.began_ms + at_ms
    index.end = end if index.places else f"{reading.NOTHING} {end}".strip()
    index.cameras = sorted(camera for topic in starts if (camera := camera_of(topic)) is not None)
    index.pictures = sum(len(times) for topic, times in starts.items() if topic.startswith(CAMERA))
    index.needs = needed_slices(starts.values(), len(index.places))
    return index


def _event(at_ms: int, text: str) -> dict[str, Any]:
    return {"what": "fault", "text": text, "level": "warning", "after_ms": at_ms}


def _note(index: Index, message: Message, at_ms: int) -> None:
    """Take a command or an event in, if it is one that a page can tell."""
    try:
        if message.topic == COMMANDS:
            told = nameless(message).content()
            if isinstance(told["id"], int) and {"kind", "state"} <= told.keys():
                index.commands.append({"reason": "", "result": {}, **told, "after_ms": at_ms})
        elif message.topic == EVENTS:
            told = message.content()
            index.events.append({"what": "", "level": "info", **told, "text": str(told["text"]), "after_ms": at_ms})
    except (ValueError, KeyError):
        return


def _begins_anew(message: Message) -> bool:
    """Tell whether a reader needs no earlier message of this channel: true for all but deltas of byte streams."""
    if message.topic.startswith(STREAM):
        try:
            return unpack(message.data).key
        except ValueError:
            return False
    return message.topic == STATE or message.topic.startswith(CAMERA)


def read_slice(path: Path, index: Index, number: int, joints: Sequence[str], channels: Sequence[str]) -> bytes:
    """Return the packets of a slice, each after its length and its time. Raises OSError."""
    return b"".join(_packets(path, index, number, joints, channels)) if number < len(index.places) else b""


def _packets(
    path: Path, index: Index, number: int, joints: Sequence[str], channels: Sequence[str]
) -> Iterator[bytes]:  # fmt: skip
    for at_ms, message in _messages(path, index, number):
        if packet := _packet(message, joints, channels):
            yield HEAD.pack(len(packet), at_ms) + packet


def _messages(path: Path, index: Index, number: int) -> Iterator[tuple[int, Message]]:
    """Yield when each message of a slice was recorded (ms since the beginning), and the message."""
    offset, newest_ns, at_ns = index.places[number]
    axis = Axis(newest_ns, at_ns)
    for part in reading.parts(path, offset, dict(index.topics)):
        for message in part.messages:
            at_ms = axis.place(message.at_ns) // MS
            if slice_of(at_ms) > number:
                return
            if slice_of(at_ms) == number:
                yield at_ms, message


def _packet(message: Message, joints: Sequence[str], channels: Sequence[str]) -> bytes:
    """Return a message as a packet of the live path; nothing for one that is none, or that cannot be read."""
    camera = camera_of(message.topic)
    try:
        if message.topic == STATE:
            return state_packed(message.content(), joints, channels)
        if camera is not None:
            return picture_packed(message.content(), camera)
    except ValueError:
        return b""
    return message.data if message.topic.startswith(STREAM) else b""


NEAR = 12  # slices in which a picture is looked for


def picture_at(path: Path, index: Index, at_ms: int) -> bytes | None:
    """Return the JPEG that the first camera had taken last at a time (ms since the beginning), else the next one.

    None if there is none within a minute. Raises OSError.
    """
    if not index.cameras or not index.places:
        return None
    number = min(slice_of(at_ms), len(index.places) - 1)
    for one in range(number, max(-1, number - NEAR), -1):
        before = [jpeg for taken, jpeg in _pictures(path, index, one) if taken <= at_ms]
        if before:
            return before[-1]
    for one in range(number, min(len(index.places), number + NEAR)):
        for _, jpeg in _pictures(path, index, one):
            return jpeg
    return None


def _pictures(path: Path, index: Index, number: int) -> Iterator[tuple[int, bytes]]:
    """Yield when each picture of the first camera was taken in a slice (ms since the beginning), and its JPEG."""
    for at_ms, message in _messages(path, index, number):
        if camera_of(message.topic) == index.cameras[0]:
            try:
                yield at_ms, jpeg_of(message.content())
            except (ValueError, KeyError):
                continue
