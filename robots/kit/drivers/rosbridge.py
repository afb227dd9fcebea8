"""The rosbridge v2 protocol: JSON objects over WebSocket, each with an `op`. Both ends of a wire use this file.

It covers the needs of a robot: topics and services, JSON, one message a frame. Fragments, PNG and CBOR compression are
refused with a sentence, and so is every frame that cannot be read. A call is carried out all the same, and answered
without compression.
"""

import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeGuard

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
    """One frame. `name`: of the topic or service; `body`: the message or the service's arguments.

    `id` is as it was sent: any value in a call, a text or a number elsewhere. `args`: a call's arguments without names.
    `warning` names a request of the client that is not met.
    """

    op: str
    name: str = ""
    id: Any = None
    type: str = ""
    body: Message = field(default_factory=dict)
    throttle_s: float = 0.0
    args: tuple[Any, ...] = ()
    warning: str = ""

    def named(self, *names: str) -> Message:
        """Return a call's arguments by name; those without names have these, in this order."""
        return self.body or dict(zip(names, self.args, strict=False))


def received(data: str | bytes) -> Message:
    """Return the JSON object in a frame that a robot receives. Raises Malformed."""
    if isinstance(data, bytes):
        raise Malformed("send text frames with JSON; binary frames are not read")
    if len(data) > MOST_BYTES:
        raise Malformed(f"the frame is longer than {MOST_BYTES} bytes")
    return decode(data)


def operation(message: Message) -> Operation:
    """Return what a received object asks for. Raises Malformed."""
    op = message.get("op")
    if not isinstance(op, str):
        raise Malformed('there is no op; send for example {"op": "subscribe", "topic": "/irat/odom"}')
    if op == "call_service":
        return _call(message)
    ident = identifier(message)
    if op in IGNORED:
        return Operation(op, id=ident)
    name = _name(message, op)
    if message.get("compression", "none") != "none":
        raise Malformed("compression is not spoken here; send none")
    body = message.get("msg", {}) if op == "publish" else {}
    if not isinstance(body, dict):
        raise Malformed("the message must be an object with named values")
    throttle = numeral(message, "throttle_rate", 0, SLOWEST_MS, "ms")
    kind, warning = plain_type(_text(message, "type", "")), ""
    if op == "subscribe" and message.get("fragment_size") is not None:
        warning = "fragments are not sent here; a message is one frame"
    return Operation(op, name, ident, kind, body, throttle / 1000, warning=warning)


def _call(found: Message) -> Operation:
    """Return a call, in which only the service's name can be wrong, so that a hold holds. Raises Malformed.

    By the protocol arguments are an object, a list in the order of the request's fields, or nothing.
    """
    args, warning = found.get("args"), ""
    if found.get("compression", "none") != "none" or any(key in found for key in ("png", "fragment_size")):
        warning = "compression is not spoken here and fragments are not sent; the answer is plain JSON in one frame"
    return Operation(
        "call_service", _name(found, "call_service"), found.get("id"), warning=warning,
        body=args if isinstance(args, dict) else {}, args=tuple(args) if isinstance(args, list) else (),
    )  # fmt: skip


def _name(found: Message, op: str) -> str:
    """Return the name of the topic or service, with its slash. Raises Malformed."""
    if op not in NAMED_BY:
        raise Malformed(f"the op {op[:30]!r} is not spoken here; known: {', '.join(NAMED_BY)}")
    name = _text(found, NAMED_BY[op])
    if not NAME.fullmatch(name):
        raise Malformed(f"{name[:60]!r} is not a name; names look like /robot/part")
    return "/" + name.lstrip("/")


def decode(data: str | bytes) -> Message:
    """Return a frame's JSON object. Raises Malformed.

    NaN and Infinity are read, too: a rosbridge_server that finds them in a NumPy array writes them as they are.
    """
    try:
        found = msgspec.json.decode(data)
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        try:
            found = json.loads(data)
            msgspec.json.encode(found)  # half a surrogate pair could not be written again
        except (ValueError, RecursionError):
            raise Malformed(f"this is not JSON: {error}") from error
    if not isinstance(found, dict):
        raise Malformed("a frame is one JSON object")
    return found


def encode(**fields: Any) -> str:
    """Return a frame; fields that are None are left out."""
    return msgspec.json.encode({name: value for name, value in fields.items() if value is not None}).decode()


def identifier(message: Mapping[str, Any]) -> str | int | None:
    """Return a frame's id as it was sent, None if it has none. Raises Malformed."""
    ident = message.get("id")
    if ident is None:
        return None
    if not isinstance(ident, str | int) or len(str(ident)) > LONGEST_NAME:
        raise Malformed(f"an id is a text of at most {LONGEST_NAME} characters")
    return ident


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
    message: Mapping[str, Any], name: str, low: float, high: float, unit: str = "", default: float = 0.0
) -> float:
    """Return a finite number of a message within its bounds; `default` if it is missing.

    Raises:
        Malformed: it is no number.
        OutOfBounds: it is outside its bounds.

    """
    value = message.get(name, default)
    if not is_number(value):
        raise Malformed(f"{name} must be a number")
    if not low <= value <= high:
        raise OutOfBounds(f"{name} is {_shown(value)}; it must be from {low:g} to {high:g} {unit}".rstrip())
    return float(value)


def is_number(value: object) -> TypeGuard[int | float]:
    """Return whether a value of JSON is a finite number; an integer may be larger than any float."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < math.inf


def _shown(value: float) -> str:
    if abs(value) < 1e15:
        return f"{value:g}"
    try:
        return f"{float(value):.3g}"
    except OverflowError:
        return f"an integer of {len(str(abs(value)))} digits"


def nested(message: Mapping[str, Any], name: str) -> Message:
    """Return an object within a message, empty if it is missing. Raises Malformed."""
    value = message.get(name, {})
    if not isinstance(value, dict):
        raise Malformed(f"{name} must be an object with named values")
    return value
