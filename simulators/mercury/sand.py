"""A bed of dry sand: a height field with an angle of repose, and objects buried in it.

Heights in mm above the tray, on a 1 mm grid; light is computed on a 0.5 mm grid so that grains are visible. Every
computation is local, because a burst changes only a small area.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, zoom

from robots.kit.drivers.mercury.beds import FIRST, Places
from robots.kit.files import replaced
from simulators.mercury.artifacts import ARTIFACTS, PIXEL_MM
from simulators.mercury.light import REACH, illuminate
from simulators.mercury.slide import finer, slide, steeper

F32 = NDArray[np.float32]
Window = tuple[int, int, int, int]  # first and last + 1 row, first and last + 1 column
X0_MM, X1_MM, Y0_MM, Y1_MM = -320, 320, 220, 620  # the tray
LEVEL_MM = 40.0  # mean height of the sand: Z = 0 is some centimetres above
JET_RADIUS_MM = 11.0
JET_DEPTH_MM_S = 34.0  # depth dug at the middle by a second of air
EDGE, GROWTH = 3, 40  # mm: if the edge of a window is too steep, a wider window follows
COVER_MM = 0.25  # thinner sand does not hide an object


class SandBed:
    """The sand, the objects in it, and the brightness of each half millimetre."""

    def __init__(self, seed: int = 1, places: Places = FIRST) -> None:
        """Pour the sand that a seed gives over the objects at these places (mm, their middles by name)."""
        rows, columns = Y1_MM - Y0_MM, X1_MM - X0_MM
        rng = np.random.default_rng(seed)
        waves = gaussian_filter(rng.normal(size=(rows, columns)), 26) * 90
        ripples = gaussian_filter(rng.normal(size=(rows, columns)), 5) * 5
        self.sand: F32 = (LEVEL_MM + waves + ripples).astype(np.float32)
        grain = rng.normal(size=(2 * rows, 2 * columns))
        grain = 0.6 * grain + 0.9 * gaussian_filter(rng.normal(size=grain.shape), 1.2) * 3
        self.grain: F32 = np.clip(0.56 + 0.045 * grain, 0.3, 0.9).astype(np.float32)
        self._bury(places)
        self.sand = np.maximum(self.sand, self.rigid + 0.1)
        self.light: F32 = np.zeros(self.grain.shape, np.float32)
        self._shade(0, rows, 0, columns)

    def _bury(self, places: Places) -> None:
        """Place the objects: `rigid` is the surface under the sand, `skin` its brightness."""
        self.rigid: F32 = np.zeros(self.sand.shape, np.float32)  # `zeros_like` would write to every page
        self.skin: F32 = np.zeros(self.grain.shape, np.float32)
        self.gloss: F32 = np.zeros(self.grain.shape, np.float32)
        for thing in ARTIFACTS:
            albedo, mask = thing.sprite()
            x_mm, y_mm = places[thing.name]
            r = int((y_mm - Y0_MM) / PIXEL_MM) - mask.shape[0] // 2
            c = int((x_mm - X0_MM) / PIXEL_MM) - mask.shape[1] // 2
            spot = self.skin[r : r + mask.shape[0], c : c + mask.shape[1]]
            spot[mask > 0.5] = albedo[mask > 0.5]
            self.gloss[r : r + mask.shape[0], c : c + mask.shape[1]][mask > 0.5] = thing.gloss
            coarse = zoom(mask, 0.5, order=1) > 0.5
            r, c = r // 2, c // 2
            surface = self.sand[r : r + coarse.shape[0], c : c + coarse.shape[1]]
            top = float(np.median(surface)) - thing.depth_mm
            edge = gaussian_filter(coarse.astype(np.float32), 1.0)
            v, u = (np.linspace(-1, 1, n) for n in coarse.shape)
            low = thing.thick_mm * (1 - np.clip(edge * 1.6, 0, 1)) + thing.dome_mm * np.clip(
                v[:, None] ** 2 + u**2, 0, 1
            )
            rise = (top - low).astype(np.float32)
            under = self.rigid[r : r + coarse.shape[0], c : c + coarse.shape[1]]
            under[coarse] = rise[coarse]

    def blow(self, x_mm: float, y_mm: float, seconds: float) -> float:
        """Move sand away from under the nozzle; return the volume (mm3)."""
        reach = 80
        r0, r1 = max(0, int(y_mm) - Y0_MM - reach), min(self.sand.shape[0], int(y_mm) - Y0_MM + reach)
        c0, c1 = max(0, int(x_mm) - X0_MM - reach), min(self.sand.shape[1], int(x_mm) - X0_MM + reach)
        sand, rigid = self.sand[r0:r1, c0:c1], self.rigid[r0:r1, c0:c1]
        yy, xx = np.mgrid[r0:r1, c0:c1].astype(np.float32)
        distance = np.hypot(xx + X0_MM - x_mm, yy + Y0_MM - y_mm)
        dig = JET_DEPTH_MM_S * seconds * np.exp(-((distance / JET_RADIUS_MM) ** 2))
        taken = np.minimum(dig, sand - rigid).astype(np.float32)
        ring = np.exp(-(((distance - 2.6 * JET_RADIUS_MM) / (0.8 * JET_RADIUS_MM)) ** 2))
        thrown = ring * (float(taken.sum()) / float(ring.sum()))
        sand += thrown.astype(np.float32) - taken
        self._shade(*self.relax(r0, r1, c0, c1))
        return float(taken.sum())

    def relax(self, r0: int, r1: int, c0: int, c1: int) -> Window:
        """Let the sand slide, starting in a window; return the window in which it may have moved.

        Sand moves between neighbours and its amount stays the same; rigid objects do not move.
        """
        while True:
            slide(self.sand[r0:r1, c0:c1], self.rigid[r0:r1, c0:c1])
            o0, o1, p0, p1 = self._grown(r0, r1, c0, c1, EDGE)
            steep = steeper(self.sand[o0:o1, p0:p1])
            steep[2 * EDGE : -2 * EDGE, 2 * EDGE : -2 * EDGE] = False
            wider = self._grown(r0, r1, c0, c1, GROWTH)
            if not steep.any() or wider == (r0, r1, c0, c1):
                return r0, r1, c0, c1
            r0, r1, c0, c1 = wider

    def _shade(self, r0: int, r1: int, c0: int, c1: int) -> None:
        """Compute the light of a window and of the area that its shadows can reach."""
        inner = self._grown(r0, r1, c0, c1, REACH)
        r0, r1, c0, c1 = self._grown(*inner, REACH)
        sand, rigid = self.sand[r0:r1, c0:c1], self.rigid[r0:r1, c0:c1]
        bare = (sand - rigid < COVER_MM) & (rigid > 0)
        height = finer(np.where(bare, rigid, sand), 2)
        fine = (slice(2 * r0, 2 * r1), slice(2 * c0, 2 * c1))
        showing = (finer(bare.astype(np.float32), 2) > 0.5) & (self.skin[fine] > 0)
        albedo = np.where(showing, self.skin[fine], self.grain[fine])
        light = illuminate(height, albedo, np.where(showing, self.gloss[fine], 0.0))
        i0, i1, k0, k1 = inner
        self.light[2 * i0 : 2 * i1, 2 * k0 : 2 * k1] = light[
            2 * (i0 - r0) : 2 * (i1 - r0), 2 * (k0 - c0) : 2 * (k1 - c0)
        ]

    def _grown(self, r0: int, r1: int, c0: int, c1: int, by: int) -> Window:
        rows, columns = self.sand.shape
        return max(0, r0 - by), min(rows, r1 + by), max(0, c0 - by), min(columns, c1 + by)

    def save(self, path: Path) -> None:
        """Store the bed, so that a restart finds it unchanged."""
        with replaced(path) as file:
            np.save(file, self.sand)

    def restore(self, path: Path) -> bool:
        """Take the bed from `path`; return False (and keep a fresh one) if it is unusable."""
        try:
            sand = np.load(path)
        except (OSError, ValueError, EOFError):
            return False
        if sand.shape != self.sand.shape or not np.isfinite(sand).all():
            return False
        self.sand = sand.astype(np.float32)
        self._shade(0, self.sand.shape[0], 0, self.sand.shape[1])
        return True
