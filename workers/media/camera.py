"""One camera of a robot: opened when it is needed, closed when it fails."""

import contextlib

from robots.kit.clock import SYSTEM, Clock
from robots.kit.contract.errors import CameraFault
from robots.kit.vision.masks import masked, masks_of
from robots.models import Robot
from workers.door import Door
from workers.media.source import DriverCamera, OfDriver, OpenCamera, Picture, Source, fitted, open_camera


class Camera:
    """Takes pictures in the size that the robot's description names."""

    def __init__(
        self, robot: Robot, index: int, name: str, of_driver: OfDriver, clock: Clock = SYSTEM,
        opened: OpenCamera = open_camera,
    ) -> None:  # fmt: skip
        self._description = robot.description()["camera"]
        self.index, self.name, self._of_driver = index, name, of_driver
        self.lock, self._opened = clock.lock(), opened
        self._address, self._rig = robot.camera_address(index), robot.rig_dir
        self._masks = masks_of(robot.settings, index)
        self._source: Source | None = None
        self._door = Door(CameraFault, "The camera failed")
        self._number = 0

    def configure(self, robot: Robot) -> None:
        """Use the privacy masks in `robot`, and the address, if it changed."""
        self._masks = masks_of(robot.settings, self.index)
        if robot.camera_address(self.index) != self._address:
            self.close()
            self._address = robot.camera_address(self.index)

    def grab(self, exposure_s: float | None) -> Picture:
        """Return one picture, without what privacy masks hide. Raises CameraFault."""
        with self.lock:
            try:
                with self._door.open(CameraFault):
                    if self._source is None:
                        self._source = self._open()
                    described = int(self._description["width"]), int(self._description["height"])
                    picture = fitted(self._source.grab(exposure_s), *described)
            except CameraFault:
                self.close()
                raise
            return masked(picture, self._masks)

    def _open(self) -> Source:
        colour = bool(self._description.get("colour"))
        if self._description.get("by_driver"):
            return DriverCamera(self._of_driver, self.name, colour)
        return self._opened(self._address, self._rig, self.name, colour)

    def next(self) -> int:
        """Return the number of the next picture, counted when it is taken, so that a late picture can be recognised."""
        self._number += 1
        return self._number

    def close(self) -> None:
        """Release the camera; the next picture opens it again."""
        with self.lock:
            source, self._source = self._source, None
            with contextlib.suppress(CameraFault), self._door.open():
                if source is not None:
                    source.close()
