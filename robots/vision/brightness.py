"""Correct the brightness of pictures without jumps and without blacking anything out.

Section 6.6 tells of two failures: a normalisation of each picture that jumped from light
to dark as the robot moved, and a global adjustment that reduced areas to blackness. So the
gain here follows slowly, is bounded, and the lens's fall-off is levelled.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

TARGET = 118.0
STEP = 0.03  # greatest change of gain from picture to picture
GAIN_LOW, GAIN_HIGH = 0.75, 1.6
FALL_OFF = 0.20  # of the light, from the middle to the corner


@dataclass(frozen=True)
class Brightness:
    """The gain in use; each picture gives the next one."""

    gain: float = 1.0

    def correct(self, picture: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], "Brightness"]:
        """Return the corrected picture (same shape) and the state for the next."""
        levelled = picture.astype(np.float32) * self.gain * _flat(*picture.shape[:2])
        high = levelled > 200.0  # a soft shoulder instead of a cut
        levelled[high] = 200.0 + 55.0 * np.tanh((levelled[high] - 200.0) / 55.0)
        middle = float(np.median(picture))
        wanted = min(max(TARGET / max(middle, 1.0), GAIN_LOW), GAIN_HIGH)
        change = min(max(wanted / self.gain, 1 - STEP), 1 + STEP)
        return np.clip(levelled, 0, 255).astype(np.uint8), Brightness(self.gain * change)


def _flat(rows: int, columns: int) -> NDArray[np.float32]:
    v, u = np.mgrid[-1 : 1 : rows * 1j, -1 : 1 : columns * 1j]
    return np.asarray(1 / (1 - FALL_OFF * (u**2 + v**2) / 2), np.float32)
