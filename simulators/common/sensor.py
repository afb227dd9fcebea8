"""A simulated camera's sensor: pictures as JPEG, one at a time, with the faults of a fault board."""

import io
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from robots.kit.clock import TIMER, WALL, Timer, Wall
from simulators.common import stamp
from simulators.common.faults import FaultBoard

Picture = NDArray[np.uint8]
Take = Callable[[float], Picture]


def take_with_stamp(take: Callable[[], Picture], faults: FaultBoard, wall: Wall) -> Picture:
    """Take a picture; return it with the time at which it was begun, if the fault board asks for that."""
    begun = wall()
    picture = take()
    return stamp.painted(picture, int(begun * 1000)) if faults.value("cam_stamp") else picture


def dim(picture: Picture, faults: FaultBoard, count: int) -> Picture:
    """Return a picture with the faults that darken it, every one or every other one; `count` is its number."""
    if faults.value("cam_flicker"):
        picture = (picture * (0.55, 1.0)[count % 2]).astype(np.uint8)
    return np.zeros_like(picture) if faults.value("cam_black") else picture


class Sensor:
    """Exposes a picture by `take(exposure_s)`; `count` is how many there were."""

    def __init__(self, take: Take, faults: FaultBoard, clock: Timer = TIMER, wall: Wall = WALL) -> None:
        self._take, self._faults, self._clock, self._wall = take, faults, clock, wall
        self._one_at_a_time = clock.lock()
        self._frozen: Picture | None = None
        self.count = 0

    def picture(self, exposure: float) -> bytes:
        """Return one JPEG that is exposed for so long (s)."""
        with self._one_at_a_time:
            if self._faults.value("cam_slow"):
                self._clock.sleep(self._faults.value("cam_slow"))
            if self._faults.value("cam_freeze") and self._frozen is not None:
                picture = self._frozen
            else:
                picture = take_with_stamp(lambda: self._take(exposure), self._faults, self._wall)
                self._frozen = picture
                self.count += 1
        image, scale = Image.fromarray(dim(picture, self._faults, self.count)), self._faults.value("cam_size")
        if scale and self.count % 2:
            image = image.resize((max(1, int(image.width * scale)), max(1, int(image.height * scale))))
        out = io.BytesIO()
        image.save(out, "JPEG", quality=94)
        return out.getvalue()
