"""A robot's camera in a world: the simulator's sensor with its faults, without its HTTP server."""

import numpy as np

from robots.kit.contract.errors import CameraFault
from simulators.common.faults import FaultBoard
from simulators.common.sensor import Sensor, Take
from tests.world.world import World
from workers.media.source import TIMEOUT_S, decode

EXPOSURE_S = 0.0067


class Eye:
    """A `workers.media.source.Source`."""

    def __init__(self, world: World, take: Take, faults: FaultBoard, colour: bool) -> None:
        self._world, self._faults, self._colour = world, faults, colour
        self._sensor = Sensor(take, faults, world, lambda: world.now().timestamp())

    def grab(self, exposure_s: float | None) -> np.ndarray:
        if self._faults.value("cam_gone"):
            raise CameraFault("The camera does not answer.")
        if self._faults.value("cam_slow") > TIMEOUT_S:
            self._world.sleep(TIMEOUT_S)
            raise CameraFault("The camera does not answer.")
        return decode(self._sensor.picture(exposure_s or EXPOSURE_S), self._colour)

    def close(self) -> None:
        pass
