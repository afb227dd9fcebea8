"""Privacy masks: parts of a camera's pictures that nobody sees, black before the picture goes anywhere. px."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.kit.contract.errors import BadRequest

NAME = "privacy_masks"  # of the setting
MOST, CAMERAS, FARTHEST = 32, 16, 10_000  # masks of a robot, cameras, px
ONE = "A privacy mask is [camera, x0, y0, x1, y1] in whole numbers, with x0 < x1 and y0 < y1"
Mask = tuple[int, int, int, int]


def check(value: Any) -> list[list[int]]:
    """Return the masks of a robot, tidied. Raises BadRequest."""
    if not isinstance(value, list) or len(value) > MOST:
        raise BadRequest(f"Privacy masks are a list of at most {MOST}.")
    return [_checked(one) for one in value]


def _checked(one: Any) -> list[int]:
    if not isinstance(one, list) or len(one) != 5 or not all(type(n) is int for n in one):
        raise BadRequest(f"{ONE}.")
    camera, x0, y0, x1, y1 = one
    if not (0 <= camera < CAMERAS and 0 <= x0 < x1 <= FARTHEST and 0 <= y0 < y1 <= FARTHEST):
        raise BadRequest(f"{ONE}, cameras counted from 0 to {CAMERAS - 1}, corners from 0 to {FARTHEST} px.")
    return one


def masks_of(settings: Mapping[str, Any], camera: int) -> tuple[Mask, ...]:
    """Return the masks of one camera (x0, y0, x1, y1): all of its picture where what is stored is no list of masks."""
    stored = settings.get(NAME)
    try:
        found = check([] if stored is None else stored)
    except BadRequest:
        return ((0, 0, FARTHEST, FARTHEST),)  # all black: a part that must be hidden is never shown
    return tuple((x0, y0, x1, y1) for number, x0, y0, x1, y1 in found if number == camera)


def masked(picture: NDArray[np.uint8], masks: Iterable[Sequence[int]]) -> NDArray[np.uint8]:
    """Return the picture with the masks black; the picture itself where there are none."""
    areas = list(masks)
    if not areas:
        return picture
    shown = picture.copy()  # a source may keep the picture
    for x0, y0, x1, y1 in areas:
        shown[y0:y1, x0:x1] = 0
    return shown
