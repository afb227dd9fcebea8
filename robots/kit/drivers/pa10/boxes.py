"""Forbidden boxes that staff add to the arm's own, checked before they are kept."""

import re
from typing import Any

from robots.kit.contract.errors import BadRequest

MOST_BOXES = 20


def checked(found: Any) -> list[dict[str, Any]]:
    """Return forbidden boxes with each low corner below its high corner. Raises BadRequest."""
    if not isinstance(found, list) or len(found) > MOST_BOXES:
        raise BadRequest(f"Write a list of at most {MOST_BOXES} boxes.")
    tidy = []
    for number, box in enumerate(found, 1):
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
