"""What a recording contains and when: an index, and slices of a few seconds that can be replayed one by one.

A slice holds the packets of the live path, so that a console decodes them as it always does. No Django.
"""

import struct
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from robots.contract.streams import unpack
from robots.recordings.container import CAMERA, COMMANDS, EVENTS, STATE, STREAM, Message, messages
from robots.recordings.packets import picture_packed, state_packed

SLICE_MS = 5000
HEAD = struct.Struct("<II")  # of each packet in a slice: its length, ms since the beginning of the recording
LONGEST_MS = 24 * 3600 * 1000


@dataclass
class Index:
    """When a recording begins and ends (ms since 1970), and what is in it.

    `needs` names for each slice the earliest slice that has to be read to know everything at its beginning: the last
    state, the last picture of each camera, and each byte stream since its last key packet.
    """

    began_ms: int = 0
    ended_ms: int = 0
    needs: list[int] = field(default_factory=list)
    cameras: list[int] = field(default_factory=list)
    pictures: int = 0
    commands: list[dict[str, Any]] = field(default_factory=list)
    events: list[dict[str, Any]] = field(default_factory=list)


def slice_of(at_ms: int) -> int:
    """Return the slice that holds a time (ms since the beginning)."""
    return max(0, at_ms) // SLICE_MS


def needed(starts: Iterable[Sequence[int]], slices: int) -> list[int]:
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
    """Return the index of a file. Raises OSError, ValueError."""
    index, starts = Index(), dict[str, list[int]]()
    for message in messages(path):
        now_ms = message.at_ns // 1_000_000
        index.began_ms, index.ended_ms = index.began_ms or now_ms, max(index.ended_ms, now_ms)
        at_ms = now_ms - index.began_ms
        if _begins_anew(message):
            starts.setdefault(message.topic, []).append(at_ms)
        if message.topic in (COMMANDS, EVENTS):
            told = index.commands if message.topic == COMMANDS else index.events
            told.append(message.told() | {"after_ms": at_ms})
    if not index.began_ms:
        return index
    if index.ended_ms - index.began_ms > LONGEST_MS:
        raise ValueError("a recording of more than a day")
    cameras = [topic.removeprefix(CAMERA) for topic in starts if topic.startswith(CAMERA)]
    index.cameras = sorted(int(camera) for camera in cameras if camera.isdigit())
    index.pictures = sum(len(times) for topic, times in starts.items() if topic.startswith(CAMERA))
    index.needs = needed(starts.values(), slice_of(index.ended_ms - index.began_ms) + 1)
    return index


def _begins_anew(message: Message) -> bool:
    """Tell whether what came before on this channel need not be known: all but the deltas of byte streams."""
    if message.topic.startswith(STREAM):
        try:
            return unpack(message.data).key
        except ValueError:
            return False
    return message.topic == STATE or message.topic.startswith(CAMERA)


def read_slice(
    path: Path, began_ms: int, number: int, joints: Sequence[str], channels: Sequence[str]
) -> bytes:  # fmt: skip
    """Return the packets of a slice, each after its length and its time. Raises OSError, ValueError."""
    first = (began_ms + number * SLICE_MS) * 1_000_000
    return b"".join(_packets(path, began_ms, first, joints, channels))


def _packets(
    path: Path, began_ms: int, first: int, joints: Sequence[str], channels: Sequence[str]
) -> Iterator[bytes]:  # fmt: skip
    for message in messages(path, None, first, first + SLICE_MS * 1_000_000):
        if message.topic == STATE:
            packet = state_packed(message.told(), joints, channels)
        elif message.topic.startswith(CAMERA):
            packet = picture_packed(message.told(), int(message.topic.removeprefix(CAMERA)))
        elif message.topic.startswith(STREAM):
            packet = message.data
        else:
            continue
        yield HEAD.pack(len(packet), message.at_ns // 1_000_000 - began_ms) + packet
