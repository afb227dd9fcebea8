"""The JSON schemas of a recording's channels; they stand in each file, so that other programs can read it."""

from typing import Any

_TIME = {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}}
_NUMBERS = {"type": "object", "additionalProperties": {"type": ["number", "null"]}}

_ROW = {"type": "array", "items": {"type": ["number", "null"]}}
_VELOCITY = {"description": "Of the body along and about its own axes, one for each coordinate of its pose; m/s, rad/s"}


def _object(about: str, **properties: Any) -> dict[str, Any]:
    return {"type": "object", "title": about, "properties": properties}


PICTURE = _object(
    "A picture of one camera; Foxglove's schema, and what consoles need beside it.",
    timestamp=_TIME, frame_id={"type": "string"}, format={"type": "string"},
    data={"type": "string", "contentEncoding": "base64"}, number={"type": "integer"},
    still={"type": "integer", "description": "The stored picture of this pose; 0: none."},
    joints=_ROW | {"description": "rad, m"}, pose=_ROW | {"description": "m, rad"}, twist=_ROW | _VELOCITY,
)  # fmt: skip
STATE = _object(
    "A state of the robot: rad, m, rad/s, m/s, N m, N, and the units that the metadata names for `values`.",
    number={"type": "integer"}, at_ms={"type": "integer", "description": "ms since 1970, by the robot's host"},
    moving={"type": "boolean"}, stopped={"type": "boolean"}, mode={"type": "string"}, joints=_NUMBERS,
    velocities=_NUMBERS, torques=_NUMBERS, values=_NUMBERS, twist=_ROW | _VELOCITY,
)  # fmt: skip
COMMAND = _object(
    "A stage of a command.",
    id={"type": "integer"}, seq={"type": "integer"}, grant={"type": "integer"}, kind={"type": "string"},
    state={"type": "string"}, reason={"type": "string"}, at_ms={"type": "integer"}, result={"type": "object"},
    progress={"type": "object"}, args={"type": "object"},
)  # fmt: skip
EVENT = _object(
    "Something that was told, or that happened to the recording.",
    what={"type": "string"}, text={"type": "string"}, level={"type": "string"},
)  # fmt: skip
# by channel, cameras together: name and schema
SCHEMAS: dict[str, tuple[str, dict[str, Any]]] = {
    "camera/": ("foxglove.CompressedImage", PICTURE), "state": ("farhand.State", STATE),
    "commands": ("farhand.Command", COMMAND), "events": ("farhand.Event", EVENT),
}  # fmt: skip
