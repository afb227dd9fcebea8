"""The file of a recording: MCAP with one channel a camera, and channels for states, commands, events and byte streams.

`docs/reference/recordings.md` says the format. No Django. All times are ns since 1970, by the database's clock.
"""

import base64
import json
import os
import struct
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any
from zlib import error as ZlibError

import msgspec
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, SeekingReader
from mcap.writer import Writer
from zstandard import ZstdError

from robots.recordings.schemas import SCHEMAS

CHUNK = 256 * 1024  # bytes before compression
PROFILE = "farhand"
STATE, COMMANDS, EVENTS = "state", "commands", "events"
CAMERA, STREAM = "camera/", "stream/"
RAW = "farhand.stream"  # the encoding of byte streams: their packets, unchanged
TORN = (McapError, ValueError, struct.error, ZstdError, ZlibError, EOFError, KeyError, IndexError)
_encode = msgspec.json.Encoder().encode


@dataclass(frozen=True)
class Message:
    """One message: its channel, when it arrived, when it was sent (ns; 0: not told), and its bytes."""

    topic: str
    at_ns: int
    sent_ns: int
    data: bytes

    def told(self) -> dict[str, Any]:
        """Return the object of a JSON channel. Raises ValueError."""
        found = json.loads(self.data)
        if not isinstance(found, dict):
            raise ValueError("not an object")
        return found


def picture_told(camera: int, taken_ms: int, number: int, still: int, joints: tuple[float, ...], jpeg: bytes) -> Any:
    """Return a picture as the object of its channel: foxglove.CompressedImage with three fields of our own."""
    return {
        "timestamp": {"sec": taken_ms // 1000, "nsec": taken_ms % 1000 * 1_000_000}, "frame_id": f"camera{camera}",
        "format": "jpeg", "data": base64.b64encode(jpeg).decode(), "number": number, "still": still, "joints": joints,
    }  # fmt: skip


def jpeg_of(told: Mapping[str, Any]) -> bytes:
    """Return the JPEG of a picture's object. Raises ValueError."""
    try:
        return base64.b64decode(told["data"], validate=True)
    except (KeyError, TypeError) as error:
        raise ValueError("not a picture") from error


def taken_ms(told: Mapping[str, Any]) -> int:
    """Return when the picture of an object was taken, in ms since 1970. Raises ValueError."""
    try:
        return int(told["timestamp"]["sec"]) * 1000 + int(told["timestamp"]["nsec"]) // 1_000_000
    except (KeyError, TypeError) as error:
        raise ValueError("not a picture") from error


class Tape:
    """Writes one file. After an OSError nothing more is written; what was flushed before stays readable."""

    def __init__(self, path: Path, about: Mapping[str, str]) -> None:
        self._out: IO[bytes] = path.open("wb")
        self._writer = Writer(self._out, chunk_size=CHUNK)
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._pending = 0
        self.whole = 0  # bytes that make a readable file
        try:
            self._writer.start(PROFILE, "farhand")
            self._writer.add_metadata("farhand", dict(about))
            self.flush()
        except OSError:
            self._out.close()
            raise

    @property
    def size(self) -> int:
        """Return the bytes written, and those that wait for a chunk's end."""
        return self.whole + self._pending

    def put(self, topic: str, at_ns: int, told: Any, sent_ns: int = 0) -> None:
        """Write an object to a JSON channel, or bytes to a byte stream's. Raises OSError."""
        self.copy(Message(topic, at_ns, sent_ns, told if isinstance(told, bytes) else _encode(told)))

    def copy(self, message: Message) -> None:
        """Write a message as it is. Raises OSError."""
        self._writer.add_message(self._channel(message.topic), message.at_ns, message.data, message.sent_ns)
        self._pending += len(message.data)
        if self._pending >= CHUNK:
            self.flush()

    def _channel(self, topic: str) -> int:
        if topic not in self._channels:
            encoding = RAW if topic.startswith(STREAM) else "json"
            self._channels[topic] = self._writer.register_channel(topic, encoding, self._schema(topic))
        return self._channels[topic]

    def _schema(self, topic: str) -> int:
        found = SCHEMAS.get(CAMERA if topic.startswith(CAMERA) else topic)
        if found is None:
            return 0
        name, schema = found
        if name not in self._schemas:
            self._schemas[name] = self._writer.register_schema(name, "jsonschema", json.dumps(schema).encode())
        return self._schemas[name]

    def flush(self) -> None:
        """End the chunk, so that a reader finds everything so far. Raises OSError."""
        self._writer.flush()
        self.whole, self._pending = self._out.tell(), 0

    def close(self) -> None:
        """Write the index and close the file. Raises OSError."""
        try:
            self._writer.finish()
            self._out.flush()
            self.whole = self._out.tell()
        finally:
            self._out.close()

    def abandon(self) -> None:
        """Close the file after an error, without what was not written as a whole."""
        try:
            self._out.close()  # its buffer may not fit on the disk
        except OSError:
            pass
        finally:
            os.truncate(self._out.name, self.whole)


def messages(
    path: Path, topics: Iterable[str] | None = None, from_ns: int | None = None, before_ns: int | None = None
) -> Iterator[Message]:
    """Yield messages in the order of arrival; of a file that was cut off, everything up to its last whole chunk.

    Raises OSError; ValueError if it is no such file.
    """
    wanted = None if topics is None else list(topics)
    with path.open("rb") as file:
        if not _complete(file):
            yield from _torn(file, wanted, from_ns, before_ns)
            return
        reader = SeekingReader(file)
        try:
            for _, channel, one in reader.iter_messages(wanted, starting_at=from_ns, ending_before=before_ns):
                yield Message(channel.topic, one.log_time, one.publish_time, one.data)
        except TORN as error:
            raise ValueError(f"a damaged recording: {error}") from error


def topics(path: Path) -> set[str]:
    """Return the topics of its messages. Raises OSError; ValueError if it is no such file."""
    with path.open("rb") as file:
        if _complete(file):
            summary = SeekingReader(file).get_summary()
            assert summary is not None
            return {channel.topic for channel in summary.channels.values()}
    return {message.topic for message in messages(path)}


def about(path: Path) -> dict[str, str]:
    """Return what the file says of itself: robot, driver, kind. Raises OSError, ValueError."""
    with path.open("rb") as file:
        try:
            return dict(next(iter(NonSeekingReader(file).iter_metadata())).metadata)
        except (*TORN, StopIteration) as error:
            raise ValueError("not a recording") from error


def _complete(file: IO[bytes]) -> bool:
    """Tell whether the file has its index. Raises ValueError if it is no MCAP file."""
    try:
        reader = SeekingReader(file)
    except TORN as error:
        raise ValueError("not a recording") from error
    try:
        summary = reader.get_summary()
    except (*TORN, OSError):  # too short to have one
        return False
    return summary is not None and bool(summary.chunk_indexes)


def _torn(file: IO[bytes], topics: list[str] | None, from_ns: int | None, before_ns: int | None) -> Iterator[Message]:
    file.seek(0)
    found = NonSeekingReader(file).iter_messages(topics, log_time_order=False)
    while True:
        try:
            _, channel, one = next(found)
        except (*TORN, StopIteration):
            return
        if (from_ns is None or one.log_time >= from_ns) and (before_ns is None or one.log_time < before_ns):
            yield Message(channel.topic, one.log_time, one.publish_time, one.data)
