"""Corrects the brightness of pictures without jumps and without black areas.

Section 6.6 reports two failures: a normalisation of each picture that jumped from light to dark as the robot moved, and
a global adjustment that reduced areas to blackness. So the gain here changes slowly and is limited, and the lens's
fall-off is compensated. The camera's brightness follows its exposure. The short exposures that keep light streaks short
give dark pictures, so the gain is mostly above one.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

TARGET = 118.0
STEP = 0.03  # greatest change of gain from picture to picture
GAIN_LOW, GAIN_HIGH = 0.75, 2.4  # the greatest lifts sand at 1/200 s
FALL_OFF = 0.20  # of the light, from the middle to the corner


@dataclass(frozen=True)
class Brightness:
    """The present gain; each picture gives the gain of the next one."""

    gain: float | None = None

    def correct(self, picture: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], "Brightness"]:
        """Return the corrected picture (same shape) and the corrector for the next one."""
        wanted = min(max(TARGET / max(float(np.median(picture)), 1.0), GAIN_LOW), GAIN_HIGH)
        gain = self.gain or wanted
        levelled = picture.astype(np.float32) * gain * _flat(*picture.shape[:2])
        high = levelled > 200.0  # a soft shoulder instead of a cut
        levelled[high] = 200.0 + 55.0 * np.tanh((levelled[high] - 200.0) / 55.0)
        change = min(max(wanted / gain, 1 - STEP), 1 + STEP)
        return np.clip(levelled, 0, 255).astype(np.uint8), Brightness(gain * change)


def _flat(rows: int, columns: int) -> NDArray[np.float32]:
    v, u = np.mgrid[-1 : 1 : rows * 1j, -1 : 1 : columns * 1j]
    return np.asarray(1 / (1 - FALL_OFF * (u**2 + v**2) / 2), np.float32)
