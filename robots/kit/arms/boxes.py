"""Forbidden boxes that staff add to an arm's own: the setting for its spec, checked before it is stored."""

import re
from typing import TYPE_CHECKING, Any

from robots.kit.arms.described import boxes
from robots.kit.contract.capabilities import Setting
from robots.kit.contract.errors import BadRequest
from robots.kit.description import load

if TYPE_CHECKING:
    from robots.kit.arms.zones import Box

MOST_BOXES = 20
MORE_BOXES = Setting(
    "boxes", "Forbidden boxes", kind="list", check="robots.kit.arms.boxes:tidy_boxes", editor="boxes", shown=True,
    help="Beside the arm's own, in its base's frame: name, two corners in m.",
)  # fmt: skip


def added_boxes(settings: dict[str, Any]) -> "tuple[Box, ...]":
    """Return the forbidden boxes that staff have added to the arm's own (m)."""
    return boxes({"box": settings.get("boxes", ())})


def forbidden_of(driver: str, settings: dict[str, Any]) -> "tuple[Box, ...]":
    """Return all forbidden boxes of an arm, its own and those of staff (m)."""
    return (*boxes(load(driver)), *added_boxes(settings))


def tidy_boxes(value: Any) -> list[dict[str, Any]]:
    """Return forbidden boxes with each low corner below its high corner. Raises BadRequest."""
    if not isinstance(value, list) or len(value) > MOST_BOXES:
        raise BadRequest(f"Write a list of at most {MOST_BOXES} boxes.")
    tidy = []
    for number, box in enumerate(value, 1):
        name = box.get("name") if isinstance(box, dict) else None
        if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z0-9 -]{1,30}", name):
            raise BadRequest(f"Box {number} needs a name of letters, digits and spaces.")
        corners = [box.get("low"), box.get("high")]
        if not all(isinstance(c, list) and len(c) == 3 and all(_metres(v) for v in c) for c in corners):
            raise BadRequest(f"{name}: low and high are corners of three numbers each, at most 5 m away.")
        low, high = ([f(a, b) for a, b in zip(*corners, strict=True)] for f in (min, max))
        if any(b - a < 0.001 for a, b in zip(low, high, strict=True)):
            raise BadRequest(f"{name} must be at least one millimetre thick.")
        tidy.append({"name": name, "low": low, "high": high})
    return tidy


def _metres(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= 5
