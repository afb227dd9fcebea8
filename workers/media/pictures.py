"""Pictures of one robot: live ones while somebody watches, stills when a command needs one."""

import logging
import threading
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import redis
from django.conf import settings

from robots import bus
from robots.kit.clock import Clock, ms_of
from robots.kit.contract.capabilities import Stills
from robots.kit.contract.channels import finite, whole
from robots.kit.contract.errors import CameraFault
from robots.kit.contract.find import function
from robots.kit.contract.session import RobotState
from robots.kit.description import coding, views
from robots.kit.files import replaced
from robots.kit.packets import Changed
from robots.kit.vision.stability import Picture, Verdict, settle
from robots.models import Command, Frame, Grant, Robot, frame_name
from workers.door import Door
from workers.media.camera import Camera
from workers.media.source import OfDriver, OpenCamera, open_camera
from workers.media.steps import Steps, jpeg
from workers.media.video import Shot, load

log = logging.getLogger(__name__)


def grey(picture: Picture) -> Picture:
    """Return the picture without its colours."""
    return picture if picture.ndim == 2 else np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8)


@dataclass(frozen=True)
class StillPicture:
    """A picture of the robot at rest, as pixels and as a JPEG; its number, its time, and the verdict about its rest."""

    picture: Picture
    data: bytes
    number: int
    at: datetime
    verdict: Verdict


class Pictures:
    """The cameras of one robot. Stills are taken with the first camera."""

    def __init__(self, robot: Robot, clock: Clock, of_driver: OfDriver, opened: OpenCamera = open_camera) -> None:
        self._robot, self._clock = robot, clock
        self._description = robot.description().get("camera", {})
        named = enumerate(views(robot.description()))
        self.cameras = [Camera(robot, i, name, of_driver, clock, opened) for i, name in named]
        if self.cameras:
            load()  # now, while no other thread waits for it
        video = self._description.get("video_quantizer"), coding(robot.description())
        self._steps = [Steps(robot.slug, camera.index, *video, clock) for camera in self.cameras]
        self.every_s = 1.0 / float(self._description.get("fps", 4))
        self._wanted = threading.Event()
        self._spec = robot.spec()
        self._declared = self._spec.capability(Stills)
        self._stills = robot.spec().stills(robot.settings)
        corrector = self._declared.brightness if self._declared else ""
        self._brightness: Any = function(corrector)() if corrector else None
        self._door = Door(CameraFault, "The correction of the picture's brightness failed")
        self.newest_at: datetime | None = None  # when the newest picture of any camera was taken
        self.still_id = 0  # the still that shows the robot as it rests; 0 while it moves

    def close(self) -> None:
        """Release all cameras."""
        for camera in self.cameras:
            camera.close()

    def configure(self, robot: Robot) -> None:
        """Use changed settings of the robot."""
        for camera in self.cameras:
            camera.configure(robot)
        self._robot = robot
        self._stills = robot.spec().stills(robot.settings)

    def grab(self, exposure_s: float | None) -> Picture:
        """Return one picture of the first camera; without an exposure the camera chooses it. Raises CameraFault."""
        return self.cameras[0].grab(exposure_s)

    def look(self, view: str, colour: bool = False) -> Picture:
        """Return one picture of a camera by its name, grey unless in `colour`, for the driver. Raises CameraFault."""
        for camera in self.cameras:
            if camera.name == view:
                picture = camera.grab(self._declared.exposure_s if self._declared else None)
                if not colour:
                    return grey(picture)
                return picture if picture.ndim == 3 else np.asarray(cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR), np.uint8)
        raise CameraFault(f"The robot has no camera {view}.")

    def _corrected(self, picture: Picture) -> Picture:
        """Return the picture with its brightness corrected, if the robot declares a correction. Raises CameraFault."""
        if self._brightness is None:
            return picture
        with self._door.open():
            shown, self._brightness = self._brightness.correct(picture)
            return np.asarray(shown, np.uint8).reshape(picture.shape)

    def settle(self) -> Verdict:
        """Run the stability check that the robot declares; without one, take one picture. Raises CameraFault."""
        stills = self._stills
        if stills is None:
            return Verdict(self.grab(None), False, "not judged", 0.0, 1)
        return settle(lambda: grey(self.grab(stills.settle_exposure_s)), stills.threshold, stills.tries)

    def still(self, state: RobotState, grant: Grant | None, command: Command | None) -> tuple[Frame | None, Verdict]:
        """Wait for a stable picture, take the delivered one, store and publish it. Raises CameraFault.

        If the disk is full, the picture is published but not stored.
        """
        self._wanted.set()
        try:
            taken = self._take()
            fields = self._stored(taken, state)
            frame = Frame.objects.create(robot=self._robot, grant=grant, command=command, **fields) if fields else None
            self.still_id = frame.pk if frame else 0
            shot = Shot(taken.picture, taken.number, self.still_id, ms_of(taken.at))
            self._steps[0].still(shot, taken.data, self._spec.posture(state))
        finally:
            self._wanted.clear()
        bus.publish(self._robot.slug, Changed("frame"))
        return frame, taken.verdict

    def photograph(self, state: RobotState) -> dict[str, Any] | None:
        """Take a stable picture, write its file, and return the fields of its row; None if the disk is full.

        Asks no database. Raises CameraFault, also where the robot has no camera.
        """
        if not self.cameras:
            raise CameraFault("The robot has no camera.")
        self._wanted.set()
        try:
            return self._stored(self._take(), state)
        finally:
            self._wanted.clear()

    def _take(self) -> StillPicture:
        """Take a picture of the robot at rest with the first camera. Raises CameraFault."""
        with self.cameras[0].lock:
            verdict = self.settle()
            picture = self.grab(self._stills.exposure_s) if self._stills else verdict.picture
            number = self.cameras[0].next()
        shown, self.newest_at = self._corrected(picture), self._clock.now()
        return StillPicture(shown, jpeg(shown), number, self.newest_at, verdict)

    def _stored(self, taken: StillPicture, state: RobotState) -> dict[str, Any] | None:
        """Write the file and return the fields of its row; None where that failed."""
        at, shape, verdict = taken.at, taken.picture.shape, taken.verdict
        name = f"frames/{self._robot.slug}/{at:%Y%m%d}/{at:%H%M%S}{at.microsecond // 1000:03d}-{frame_name()}.jpg"
        path = Path(settings.MEDIA_ROOT) / name
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with replaced(path) as out:
                out.write(taken.data)
        except OSError as error:
            log.error("a picture could not be stored: %s", error)
            return None
        return {
            "taken_at": at, "file": name, "height": shape[0], "width": shape[1], "pose": whole(state.pose),
            "joints": whole(state.joints), "values": finite(state.values), "calibration": self._robot.calibration,
            "stable": verdict.stable, "verdict": verdict.reason, "difference": round(verdict.difference, 3),
            "tries": verdict.tries,
        }  # fmt: skip

    def live_once(self, state: RobotState | None, camera: int = 0) -> bool:
        """Send one live picture of a camera if somebody wants one now. Return False if nobody will soon."""
        source = self.cameras[camera]
        first = camera == 0
        if (first and self._wanted.is_set()) or state is None:
            return True
        now = self._clock.monotonic()
        try:
            wanted = bus.demands(self._robot.slug, camera)
        except (redis.RedisError, OSError):
            return False
        steps = self._steps[camera]
        due = steps.due(wanted, now)
        if not any((due.jpeg, due.video, due.coarse, due.coarse_video)):
            return any(demand.every_s < bus.SLOW_S for demand in wanted)
        try:
            with source.lock:
                if first and self._wanted.is_set():
                    return True  # a still was started while this thread waited for the camera
                picture = source.grab(self._declared.exposure_s if self._declared else None)
                number, still = source.next(), self.still_id if first else 0
            shown = self._corrected(picture)
        except CameraFault:
            return True
        self.newest_at = self._clock.now()
        shot = Shot(shown, number, still, ms_of(self.newest_at))
        steps.send(due, shot, self._spec.posture(state), now)
        return True
