"""Judges whether pictures are stable, by comparing pairs (Goldberg et al. 1995, section 6.6).

The paper calls the number a factor of similarity, and a picture stable if the number is below a set value. So the
number is a difference, and is called that here.
"""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from robots.kit.contract.errors import CameraFault

Picture = NDArray[np.uint8]
Grab = Callable[[], Picture]
BLACK = 4.0  # mean grey below which the camera shows nothing
VERDICTS = ("stable", "unstable", "frozen", "black", "camera stopped")


@dataclass(frozen=True)
class Verdict:
    """The newest picture and its verdict.

    `reason` is one of `VERDICTS`; `difference` in grey levels.
    """

    picture: Picture
    stable: bool
    reason: str
    difference: float
    tries: int


def difference(a: Picture, b: Picture) -> float:
    """Return the mean absolute difference in grey levels, after smoothing the noise of the sensor.

    Pictures of different shape differ by 255.
    """
    if a.shape != b.shape:
        return 255.0
    return float(np.mean(cv2.absdiff(cv2.blur(a, (3, 3)), cv2.blur(b, (3, 3)))))


def settle(grab: Grab, threshold: float, tries: int = 5) -> Verdict:
    """Take pairs until two pictures agree or `tries` pairs are over; always returns a verdict.

    Two identical pictures come from a frozen camera, because a sensor has noise, and never count as stable. Raises
    CameraFault if no picture comes.
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
