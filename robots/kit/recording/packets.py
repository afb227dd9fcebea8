"""States and pictures: from the packets of the live path to the objects of a recording, and back without a change."""

import struct
from collections.abc import Mapping, Sequence
from math import isfinite, nan
from typing import Any

from robots.kit.packets import PICTURE_HEAD, STATE_HEAD, picture_packet, unpack_state
from robots.kit.recording.container import jpeg_of, picture_told, taken_ms

ROWS = ("joints", "velocities", "torques")


def _named(names: Sequence[str], values: Sequence[float]) -> dict[str, float | None]:
    known = [*names, *(str(index) for index in range(len(names), len(values)))]
    return {name: value if isfinite(value) else None for name, value in zip(known, values, strict=False)}


def _numbers(told: Any, names: Sequence[str]) -> list[float]:
    if not isinstance(told, Mapping):
        return []
    known = [*names[: len(told)], *(str(index) for index in range(len(names), len(told)))]
    return [nan if told.get(name) is None else float(told[name]) for name in known]


def _known(values: Sequence[float]) -> list[float | None]:
    return [value if isfinite(value) else None for value in values]


def _list(told: Any) -> list[float]:
    return [nan if value is None else float(value) for value in told or ()]


def state_told(data: bytes, joints: Sequence[str], channels: Sequence[str]) -> dict[str, Any]:
    """Return the object of a state's packet, with the names that the robot's spec declares. Raises ValueError."""
    flags, number, at_ms, rows, values, mode = unpack_state(data)
    if len(rows) not in (1, len(ROWS)):
        raise ValueError("not a packet of a state")
    told: dict[str, Any] = {
        "number": number, "at_ms": at_ms, "moving": bool(flags & 1), "stopped": bool(flags & 2), "mode": mode,
    }  # fmt: skip
    for name, row in zip(ROWS, rows, strict=False):
        told[name] = _named(joints, row)
    if values is not None:
        told["values"] = _named(channels, values[: len(channels)])
        if twist := values[len(channels) :]:
            told["twist"] = _known(twist)
    return told


def state_packed(state: Mapping[str, Any], joints: Sequence[str], channels: Sequence[str]) -> bytes:
    """Return the packet of a state's object. Raises ValueError."""
    try:
        rows = [_numbers(state[name], joints) for name in ROWS if name in state]
        values = [*_numbers(state["values"], channels), *_list(state.get("twist"))] if "values" in state else None
        flags = bool(state["moving"]) | (bool(state["stopped"]) << 1) | ((values is not None) << 2)
        head = STATE_HEAD.pack(1, flags, state["number"], state["at_ms"], len(rows[0]), len(rows))
        floats = [value for row in rows for value in row]
        packed = head + struct.pack(f"<{len(floats)}f", *floats)
        if values is not None:
            packed += struct.pack(f"<B{len(values)}f", len(values), *values)
        return packed + str(state["mode"]).encode()
    except (KeyError, IndexError, TypeError, struct.error, OverflowError) as error:
        raise ValueError("not a state") from error


def picture_of(data: bytes, joints: int | None = None, pose: int = 0) -> dict[str, Any]:
    """Return the object of a picture's packet. Raises ValueError.

    Its robot has so many joints (None: it tells nothing else) and coordinates of a pose; the body's velocity follows.
    """
    try:
        kind, camera, number, at_ms, still, count = PICTURE_HEAD.unpack_from(data)
        posture = struct.unpack_from(f"<{count}f", data, PICTURE_HEAD.size)
    except struct.error as error:
        raise ValueError("not a packet of a picture") from error
    if kind != 2:
        raise ValueError("not a packet of a picture")
    known = tuple(_known(posture))
    end = count if joints is None else joints
    parts = known[:end], known[end : end + pose], known[end + pose :]
    told: dict[str, Any] = picture_told(camera, at_ms, number, still, parts[0], data[PICTURE_HEAD.size + 4 * count :])
    return told | {name: part for name, part in zip(("pose", "twist"), parts[1:], strict=True) if part}


def picture_packed(picture: Mapping[str, Any], camera: int) -> bytes:
    """Return the packet of a picture's object. Raises ValueError."""
    try:
        posture = (*_list(picture["joints"]), *_list(picture.get("pose")), *_list(picture.get("twist")))
        return picture_packet(
            int(picture["number"]), taken_ms(picture), int(picture["still"]), posture, jpeg_of(picture), camera
        )
    except (KeyError, TypeError, struct.error, OverflowError) as error:
        raise ValueError("not a picture") from error
