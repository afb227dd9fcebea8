"""The rosbridge v2 protocol: JSON objects over WebSocket, each with an `op`. Both ends of a wire use this file.

Only what a robot needs is spoken: topics and services, JSON, one message a frame. Fragments, PNG and CBOR compression
are refused with a sentence, as is everything that cannot be read.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import msgspec

MOST_BYTES = 16_384  # of a frame towards a robot
LONGEST_NAME = 200
SLOWEST_MS = 3_600_000
NAMED_BY = {
    "advertise": "topic", "unadvertise": "topic", "publish": "topic", "subscribe": "topic", "unsubscribe": "topic",
    "call_service": "service",
}  # fmt: skip
IGNORED = frozenset({"status", "set_level"})
NAME = re.compile(r"/?[A-Za-z][A-Za-z0-9_]*(/[A-Za-z0-9_]+)*")
Message = dict[str, Any]


class Malformed(ValueError):
    """A frame or a message that is not valid; the text says what was wrong and what to send."""


class OutOfBounds(Malformed):
    """A number outside its bounds; the text names value, range and unit."""


@dataclass(frozen=True)
class Operation:
    """One frame. `name`: of the topic or service; `body`: the message or the service's arguments."""

    op: str
    name: str = ""
    id: str | None = None
    type: str = ""
    body: Message = field(default_factory=dict)
    throttle_s: float = 0.0


def parse(data: str | bytes) -> Operation:
    """Return the operation in a frame that a robot receives. Raises Malformed."""
    if isinstance(data, bytes):
        raise Malformed("send text frames with JSON; binary frames are not read")
    if len(data) > MOST_BYTES:
        raise Malformed(f"the frame is longer than {MOST_BYTES} bytes")
    found = decode(data)
    op = found.get("op")
    if not isinstance(op, str):
        raise Malformed('there is no op; send for example {"op": "subscribe", "topic": "/irat/odom"}')
    ident = identifier(found)
    if op in IGNORED:
        return Operation(op, id=ident)
    if op not in NAMED_BY:
        raise Malformed(f"the op {op[:30]!r} is not spoken here; known: {', '.join(NAMED_BY)}")
    name = _text(found, NAMED_BY[op])
    if not NAME.fullmatch(name):
        raise Malformed(f"{name[:60]!r} is not a name; names look like /robot/part")
    if found.get("compression", "none") != "none":
        raise Malformed("compression is not spoken here; send none")
    body = found.get("msg" if op == "publish" else "args", {})
    if not isinstance(body, dict):
        raise Malformed(
            "the message must be an object with named values"
            if op == "publish"
            else "args must be an object with named values"
        )
    throttle = numeral(found, "throttle_rate", 0, SLOWEST_MS, "ms")
    return Operation(op, "/" + name.lstrip("/"), ident, plain_type(_text(found, "type", "")), body, throttle / 1000)


def decode(data: str | bytes) -> Message:
    """Return a frame's JSON object. Raises Malformed."""
    try:
        found = msgspec.json.decode(data)
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise Malformed(f"this is not JSON: {error}") from error
    if not isinstance(found, dict):
        raise Malformed("a frame is one JSON object")
    return found


def encode(**fields: Any) -> str:
    """Return a frame; fields that are None are left out."""
    return msgspec.json.encode({name: value for name, value in fields.items() if value is not None}).decode()


def identifier(found: Mapping[str, Any]) -> str | None:
    """Return a frame's id, None if it has none. Raises Malformed."""
    ident = found.get("id")
    if ident is None:
        return None
    if not isinstance(ident, str | int) or len(str(ident)) > LONGEST_NAME:
        raise Malformed(f"an id is a text of at most {LONGEST_NAME} characters")
    return str(ident)


def plain_type(name: str) -> str:
    """Return a message's type as ROS 1 writes it: ROS 2 says `geometry_msgs/msg/Twist`."""
    return name.replace("/msg/", "/").replace("/srv/", "/")


def _text(found: Mapping[str, Any], name: str, default: str | None = None) -> str:
    value = found.get(name, default)
    if value is None and default is not None:
        return default
    if not isinstance(value, str) or len(value) > LONGEST_NAME:
        raise Malformed(f"{name} must be a text of at most {LONGEST_NAME} characters")
    return value


def numeral(
    found: Mapping[str, Any], name: str, low: float, high: float, unit: str = "", default: float = 0.0
) -> float:
    """Return a finite number of a message within its bounds; `default` if it is missing.

    Raises:
        Malformed: it is no number.
        OutOfBounds: it is outside its bounds.

    """
    value = found.get(name, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise Malformed(f"{name} must be a number")
    if not low <= value <= high:
        raise OutOfBounds(f"{name} is {_shown(value)}; it must be from {low:g} to {high:g} {unit}".rstrip())
    return float(value)


def _shown(value: float) -> str:
    return f"{value:g}" if abs(value) < 1e15 else f"{float(value):.3g}"


def nested(found: Mapping[str, Any], name: str) -> Message:
    """Return an object within a message, empty if it is missing. Raises Malformed."""
    value = found.get(name, {})
    if not isinstance(value, dict):
        raise Malformed(f"{name} must be an object with named values")
    return value
