"""The picture of the CCD camera on the arm: 192 x 165 pixels, 256 greys (section 6.6).

The camera looks straight down from beside the nozzle, so its field of view grows with Z. Its mounting is a little
shifted and turned; calibration measures this. Its fixed focus lies between the two heights. Exposure
blurs motion, and brightness depends on it.

The chip has no shutter against too much light: a pixel that overflows spills its charge along its column, "light
streaking that the camera is prone to". A shorter exposure gives a shorter streak, hence the paper's 1/150 s.
"""

from math import cos, radians, sin

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, map_coordinates

from simulators.mercury.sand import LEVEL_MM, X0_MM, Y0_MM, SandBed

WIDTH, HEIGHT = 192, 165
FOCAL_PX = 262.0
ABOVE_MM = 128.0  # lens above the mean sand at Z = 0
OFF_X_MM, OFF_Y_MM, TURN_RAD = 3.0, -2.2, radians(2.4)  # mounting errors
FOCUS_MM = 158.0
DISTORTION = -0.10
WHITE_AT_S = 1 / 74  # the exposure that shows white paper just white: flat sand is 165 of 255 at 1/64 s, 70 at 1/150
WELL = 1.6 * 255  # charge, in grey levels, above which a pixel spills
SPILL = 0.025  # share of the spilt charge that stays in each pixel of the column
NOISE = 0.9

_V, _U = np.mgrid[0:HEIGHT, 0:WIDTH].astype(np.float32)
_UN = (_U - (WIDTH - 1) / 2) / FOCAL_PX
_VN = -(_V - (HEIGHT - 1) / 2) / FOCAL_PX
_R2 = _UN**2 + _VN**2
_UN = _UN * (1 + DISTORTION * _R2)
_VN = _VN * (1 + DISTORTION * _R2)
_VIGNETTE = (1 - 0.9 * _R2).astype(np.float32)


def expose(
    bed: SandBed,
    poses: list[tuple[float, float, float, float]],
    exposure_s: float,
    rng: np.random.Generator,
) -> NDArray[np.uint8]:
    """Return the picture, shape (165, 192), taken while the tool was at `poses` (m, rad)."""
    total = np.zeros((HEIGHT, WIDTH), np.float32)
    for x, y, z, theta in poses:
        distance = ABOVE_MM + z * 1000
        turn = theta + TURN_RAD
        c, s = cos(turn), sin(turn)
        ox = x * 1000 + cos(theta) * OFF_X_MM - sin(theta) * OFF_Y_MM
        oy = y * 1000 + sin(theta) * OFF_X_MM + cos(theta) * OFF_Y_MM
        dx, dy = c * _UN - s * _VN, s * _UN + c * _VN
        gx, gy = ox + dx * distance, oy + dy * distance
        rows, columns = gy - Y0_MM, gx - X0_MM
        r = np.clip(rows.astype(np.int32), 0, bed.sand.shape[0] - 1)
        k = np.clip(columns.astype(np.int32), 0, bed.sand.shape[1] - 1)
        rise = bed.sand[r, k] - LEVEL_MM  # parallax of hills
        at = np.stack((2 * (rows - dy * rise), 2 * (columns - dx * rise)))
        total += map_coordinates(bed.light, at, order=1, mode="nearest", prefilter=False)
    light = total / len(poses)
    mean_distance = ABOVE_MM + 1000 * sum(p[2] for p in poses) / len(poses)
    blur = 0.35 + 26.0 * abs(1 / mean_distance - 1 / FOCUS_MM) * 10
    light = gaussian_filter(light, blur) * _VIGNETTE
    charge = spilt(255.0 * (exposure_s / WHITE_AT_S) * light)
    grey = charge + rng.normal(0, NOISE, light.shape).astype(np.float32)
    return np.asarray(np.clip(grey, 0, 255), np.uint8)


def spilt(charge: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the charge, shape (rows, columns), in grey levels, after overflow ran along the columns."""
    over = np.maximum(charge - WELL, 0.0)
    if not over.any():
        return charge
    kept = np.minimum(charge, WELL)
    for rows in (range(len(kept)), range(len(kept) - 1, -1, -1)):
        running = np.zeros(kept.shape[1], np.float32)
        for row in rows:
            taken = np.minimum(SPILL * running, np.maximum(255.0 - kept[row], 0.0))
            kept[row] += taken
            running += over[row] / 2 - taken
    return kept
