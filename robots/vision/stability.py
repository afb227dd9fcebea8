"""Is the picture stable? Pairs of pictures are compared (Goldberg et al. 1995, section 6.6).

The paper calls the number a factor of similarity and a picture stable when it lies below a
set value; that is a difference, and is called one here.
"""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from robots.drivers.errors import CameraFault

Picture = NDArray[np.uint8]
Grab = Callable[[], Picture]
BLACK = 4.0  # mean grey below which the camera shows nothing


@dataclass(frozen=True)
class Verdict:
    """The newest picture and what is known about it.

    `reason` is one of stable, unstable, frozen, black; `difference` in grey levels.
    """

    picture: Picture
    stable: bool
    reason: str
    difference: float
    tries: int


def difference(a: Picture, b: Picture) -> float:
    """Return the mean absolute difference in grey levels, grain of the sensor smoothed away.

    Pictures of unlike shape differ by 255.
    """
    if a.shape != b.shape:
        return 255.0
    return float(np.mean(cv2.absdiff(cv2.blur(a, (3, 3)), cv2.blur(b, (3, 3)))))


def settle(grab: Grab, threshold: float, tries: int = 5) -> Verdict:
    """Take pairs until two pictures agree or `tries` pairs are over; always answers.

    Two pictures that are the same to the last bit come from a frozen camera (a sensor has
    noise), and never count as stable. Raises CameraFault where no picture comes at all.
    """
    newest: Picture | None = None
    factor = 255.0
    reason = "unstable"
    for attempt in range(1, tries + 1):
        try:
            first, newest = grab(), grab()
        except CameraFault:
            if newest is None:
                raise
            return Verdict(newest, False, "camera stopped", factor, attempt)
        factor = difference(first, newest)
        if np.array_equal(first, newest):
            reason = "black" if float(newest.mean()) < BLACK else "frozen"
        elif float(newest.mean()) < BLACK:
            reason = "black"
        elif factor < threshold:
            return Verdict(newest, True, "stable", factor, attempt)
        else:
            reason = "unstable"
    assert newest is not None
    return Verdict(newest, False, reason, factor, tries)
