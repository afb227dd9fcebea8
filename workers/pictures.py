"""Pictures of one robot: live ones while somebody watches, stills when a command needs one."""

import contextlib
import logging
import threading
from pathlib import Path
from typing import Any

import cv2
import redis
from django.conf import settings

from robots import bus
from robots.clock import Clock
from robots.drivers.contract import RobotState
from robots.drivers.errors import CameraFault
from robots.messages import Changed, picture_packet
from robots.models import Command, Frame, Grant, Robot, frame_name
from robots.vision.brightness import Brightness
from robots.vision.stability import Picture, Verdict, settle
from workers.cameras import Camera, open_camera

log = logging.getLogger(__name__)
LIVE_S = 0.25


def jpeg(picture: Picture, quality: int = 88) -> bytes:
    """Return the picture as JPEG."""
    return bytes(cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])[1])


class Pictures:
    """The camera of one robot and what is done with its pictures."""

    def __init__(self, robot: Robot, clock: Clock) -> None:
        self._robot, self._clock = robot, clock
        self._description = robot.description()["camera"]
        self._lock = threading.RLock()
        self._wanted = threading.Event()
        self._camera: Camera | None = None
        self._brightness = Brightness()
        self._number = 0
        self.still_id = 0  # of the pose the robot rests in; 0 while it moves
        self.fault = ""

    def configure(self, robot: Robot) -> None:
        """Take over changed settings."""
        if robot.camera != self._robot.camera:
            self._drop()
        self._robot = robot

    def grab(self, exposure_s: float) -> Picture:
        """Return one picture. Raises CameraFault."""
        with self._lock:
            try:
                if self._camera is None:
                    self._camera = open_camera(self._robot.camera, self._robot.rig_dir)
                picture = self._camera.grab(exposure_s)
            except CameraFault as error:
                self.fault = str(error)
                self._drop()
                raise
            self.fault = ""
            return picture

    def _drop(self) -> None:
        with self._lock, contextlib.suppress(Exception):
            if self._camera is not None:
                self._camera.close()
            self._camera = None

    def settle(self) -> Verdict:
        """Run the stability check. Raises CameraFault."""
        exposure = float(self._description["stability_exposure_s"])
        threshold = self._robot.stability_threshold or float(self._description["stability_threshold"])
        return settle(lambda: self.grab(exposure), threshold, int(self._description["stability_tries"]))

    def still(self, state: RobotState, grant: Grant | None, command: Command | None) -> tuple[Frame | None, Verdict]:
        """Wait for a stable picture, take the delivered one, keep and publish it.

        A full disk loses the kept copy, not the picture. Raises CameraFault.
        """
        self._wanted.set()
        try:
            with self._lock:
                verdict = self.settle()
                low, high = self._description["exposure_range_s"]
                exposure = self._robot.delivery_exposure_s or float(self._description["delivery_exposure_s"])
                picture = self.grab(min(max(exposure, low), high))
        finally:
            self._wanted.clear()
        shown, self._brightness = self._brightness.correct(picture)
        data = jpeg(shown)
        at = self._clock.now()
        frame = self._keep(data, shown.shape, at, state, grant, command, verdict)
        self.still_id = frame.pk if frame else 0
        self._publish(data, state, at)
        bus.publish(self._robot.slug, Changed("frame"))
        return frame, verdict

    def _keep(
        self, data: bytes, shape: tuple[int, ...], at: Any, state: RobotState,
        grant: Grant | None, command: Command | None, verdict: Verdict,
    ) -> Frame | None:  # fmt: skip
        name = f"frames/{self._robot.slug}/{at:%Y%m%d}/{at:%H%M%S}{at.microsecond // 1000:03d}-{frame_name()}.jpg"
        path = Path(settings.MEDIA_ROOT) / name
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            part = path.with_suffix(".part")
            part.write_bytes(data)
            part.replace(path)
        except OSError as error:
            log.error("a picture could not be kept: %s", error)
            return None
        return Frame.objects.create(
            robot=self._robot, grant=grant, command=command, taken_at=at, file=name,
            height=shape[0], width=shape[1], pose=list(state.pose), joints=list(state.joints),
            calibration=self._robot.calibration, stable=verdict.stable, verdict=verdict.reason,
            difference=round(verdict.difference, 3), tries=verdict.tries,
        )  # fmt: skip

    def _publish(self, data: bytes, state: RobotState, at: Any) -> None:
        self._number += 1
        bus.publish_picture(
            self._robot.slug,
            picture_packet(self._number, int(at.timestamp() * 1000), self.still_id, state.joints, data),
        )

    def live_once(self, state: RobotState | None) -> None:
        """Send one live picture if somebody watches; called in a loop."""
        if self._wanted.is_set() or state is None:
            return
        try:
            if not bus.watched(self._robot.slug):
                return
        except (redis.RedisError, OSError):
            return
        try:
            picture = self.grab(float(self._description["delivery_exposure_s"]))
        except CameraFault:
            return
        shown, self._brightness = self._brightness.correct(picture)
        self._publish(jpeg(shown, 80), state, self._clock.now())
