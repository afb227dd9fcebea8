"""The file of a recording: MCAP with one channel a camera, and channels for states, commands, events and byte streams.

`docs/reference/recordings.md` says the format; `reading` reads it. No Django. All times are ns since 1970, by the
database's clock.
"""

import base64
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, Any

import msgspec
from mcap.writer import Writer

CHUNK = 256 * 1024  # bytes before compression
PROFILE = "farhand"
STATE, COMMANDS, EVENTS = "state", "commands", "events"
CAMERA, STREAM = "camera/", "stream/"
RAW = "farhand.stream"  # the encoding of byte streams: their packets, unchanged
_encode = msgspec.json.Encoder().encode

# The JSON schemas of the channels; they stand in each file, so that other programs can read it.
_TIME = {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}}
_NUMBERS = {"type": "object", "additionalProperties": {"type": ["number", "null"]}}
_ROW = {"type": "array", "items": {"type": ["number", "null"]}}
_VELOCITY = {"description": "Of the body along and about its own axes, one for each coordinate of its pose; m/s, rad/s"}


def _object(about: str, **properties: Any) -> dict[str, Any]:
    return {"type": "object", "title": about, "properties": properties}


_PICTURE = _object(
    "A picture of one camera; Foxglove's schema, and what consoles need beside it.",
    timestamp=_TIME, frame_id={"type": "string"}, format={"type": "string"},
    data={"type": "string", "contentEncoding": "base64"}, number={"type": "integer"},
    still={"type": "integer", "description": "The stored picture of this pose; 0: none."},
    joints=_ROW | {"description": "rad, m"}, pose=_ROW | {"description": "m, rad"}, twist=_ROW | _VELOCITY,
)  # fmt: skip
_STATE = _object(
    "A state of the robot: rad, m, rad/s, m/s, N m, N, and the units that the metadata names for `values`.",
    number={"type": "integer"}, at_ms={"type": "integer", "description": "ms since 1970, by the robot's host"},
    moving={"type": "boolean"}, stopped={"type": "boolean"}, mode={"type": "string"}, joints=_NUMBERS,
    velocities=_NUMBERS, torques=_NUMBERS, values=_NUMBERS, twist=_ROW | _VELOCITY,
)  # fmt: skip
_COMMAND = _object(
    "A stage of a command.",
    id={"type": "integer"}, seq={"type": "integer"}, grant={"type": "integer"}, kind={"type": "string"},
    state={"type": "string"}, reason={"type": "string"}, at_ms={"type": "integer"}, result={"type": "object"},
    progress={"type": "object"}, args={"type": "object"}, target={"type": "object"},
)  # fmt: skip
_EVENT = _object(
    "Something that was told, or that happened to the recording.",
    what={"type": "string"}, text={"type": "string"}, level={"type": "string"},
)  # fmt: skip
# by channel, cameras together: name and schema
SCHEMAS: dict[str, tuple[str, dict[str, Any]]] = {
    CAMERA: ("foxglove.CompressedImage", _PICTURE), STATE: ("farhand.State", _STATE),
    COMMANDS: ("farhand.Command", _COMMAND), EVENTS: ("farhand.Event", _EVENT),
}  # fmt: skip


@dataclass(frozen=True)
class Message:
    """One message: its channel, when it arrived, when it was sent (ns; 0: not told), and its bytes."""

    topic: str
    at_ns: int
    sent_ns: int
    data: bytes

    def content(self) -> dict[str, Any]:
        """Return the object of a JSON channel. Raises ValueError."""
        try:
            found = json.loads(self.data)
        except RecursionError as error:
            raise ValueError("not an object") from error
        if not isinstance(found, dict):
            raise ValueError("not an object")
        return found


def nameless(message: Message) -> Message:
    """Return a command's message without the handle of its operator, which earlier versions wrote; others unchanged."""
    if message.topic != COMMANDS or b'"by"' not in message.data:
        return message
    try:
        told = message.content()
    except ValueError:
        return message
    told.pop("by", None)
    return replace(message, data=_encode(told))


def picture_told(
    camera: int, taken_ms: int, number: int, still: int, joints: tuple[float | None, ...], jpeg: bytes
) -> Any:
    """Return a picture as the object of its channel: foxglove.CompressedImage with three fields of our own."""
    return {
        "timestamp": {"sec": taken_ms // 1000, "nsec": taken_ms % 1000 * 1_000_000}, "frame_id": f"camera{camera}",
        "format": "jpeg", "data": base64.b64encode(jpeg).decode(), "number": number, "still": still, "joints": joints,
    }  # fmt: skip


def camera_of(topic: str) -> int | None:
    """Return the camera of a topic; None for another topic."""
    number = topic.removeprefix(CAMERA)
    return int(number) if topic.startswith(CAMERA) and number.isascii() and number.isdigit() else None


def jpeg_of(picture: Mapping[str, Any]) -> bytes:
    """Return the JPEG of a picture's object. Raises ValueError."""
    try:
        return base64.b64decode(picture["data"], validate=True)
    except (KeyError, TypeError) as error:
        raise ValueError("not a picture") from error


def taken_ms(picture: Mapping[str, Any]) -> int:
    """Return when the picture of an object was taken, in ms since 1970. Raises ValueError."""
    try:
        return int(picture["timestamp"]["sec"]) * 1000 + int(picture["timestamp"]["nsec"]) // 1_000_000
    except (KeyError, TypeError, OverflowError) as error:
        raise ValueError("not a picture") from error


class Tape:
    """Writes one file. After an OSError nothing more is written; everything that was flushed before stays readable."""

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

    def put(self, topic: str, at_ns: int, message: Any, sent_ns: int = 0) -> None:
        """Write an object to a JSON channel, or bytes to a byte stream's. Raises OSError."""
        self.copy(Message(topic, at_ns, sent_ns, message if isinstance(message, bytes) else _encode(message)))

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
