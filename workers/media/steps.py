"""The ways in which one camera's live pictures are sent: whole or coarse, as JPEG or video; made once, if wanted."""

from typing import NamedTuple

import cv2

from robots import bus
from robots.kit.clock import SYSTEM, Timer
from robots.kit.description import CODING
from robots.kit.packets import picture_packet
from robots.kit.vision.stability import Picture
from workers.media.video import QUANTIZER, Shot, Video

QUALITY, COARSE_QUALITY = 80, 20  # of JPEG
COARSER = 50  # the quantizer of coarse video, at least
COARSE_S = 0.2  # between two coarse pictures, about
EARLY_S = 0.02  # a picture may come so much before its time


def jpeg(picture: Picture, quality: int = 88) -> bytes:
    """Return the picture as JPEG."""
    return bytes(cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])[1])


class Due(NamedTuple):
    """The forms that have to be made of the next picture; `key`, `coarse_key`: that video needs a key frame."""

    jpeg: bool
    video: bool
    coarse: bool
    coarse_video: bool
    key: bool
    coarse_key: bool


class Steps:
    """The live pictures of one camera. Times are those of one clock (s)."""

    def __init__(
        self, slug: str, camera: int, quantizer: int | None, coding: str = CODING, clock: Timer = SYSTEM
    ) -> None:
        self._slug, self._camera = slug, camera
        fine = QUANTIZER if quantizer is None else quantizer
        self._video = Video(slug, camera, fine, coding=coding, clock=clock)
        self._coarse_video = Video(slug, camera, max(fine, COARSER), coarse=True, coding=coding, clock=clock)
        self._jpeg_at = self._coarse_at = float("-inf")
        self._coarse = False  # somebody wants coarse JPEG, when it was last looked

    def due(self, wanted: frozenset[bus.Demand], now: float) -> Due:
        """Return the forms that have to be made of a picture taken now."""
        since = now - self._jpeg_at + EARLY_S
        jpeg = any(since >= demand.every_s for demand in wanted if not (demand.video or demand.coarse))
        video = {(demand.coarse, demand.key) for demand in wanted if demand.video}
        self._coarse = any(demand.coarse and not demand.video for demand in wanted)
        coarse = now - self._coarse_at >= 0.9 * COARSE_S
        return Due(
            jpeg,
            (False, False) in video,
            coarse and self._coarse,
            coarse and (True, False) in video,
            (False, True) in video,
            (True, True) in video,
        )

    def send(self, due: Due, shot: Shot, posture: tuple[float, ...], now: float) -> None:
        """Make and send what is due; `posture` is where the robot is, as `Spec.posture` tells it."""
        if due.jpeg:
            self._jpeg_at = now
            self._publish(shot, posture, QUALITY, coarse=False)
        if due.coarse:
            self._publish(shot, posture, COARSE_QUALITY, coarse=True)
        if due.coarse or due.coarse_video:
            self._coarse_at = now
        if due.video:
            self._video.take(shot, due.key)
        if due.coarse_video:
            self._coarse_video.take(shot, due.coarse_key)

    def still(self, shot: Shot, data: bytes, posture: tuple[float, ...]) -> None:
        """Send a stored picture, whose JPEG is `data`, to everybody who watches."""
        bus.publish_picture(self._slug, self._packet(shot, posture, data), self._camera)
        if self._coarse:
            self._publish(shot, posture, COARSE_QUALITY, coarse=True)
        for video in (self._video, self._coarse_video):
            if video.running:
                video.take(shot)

    def _packet(self, shot: Shot, posture: tuple[float, ...], data: bytes) -> bytes:
        return picture_packet(shot.number, shot.at_ms, shot.still, posture, data, self._camera)

    def _publish(self, shot: Shot, posture: tuple[float, ...], quality: int, coarse: bool) -> None:
        packet = self._packet(shot, posture, jpeg(shot.picture, quality))
        bus.publish_picture(self._slug, packet, self._camera, coarse)
