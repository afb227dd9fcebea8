"""The video of one camera, encoded once for all who watch it, while somebody does.

The encoder has a thread of its own, and drops pictures that come faster than it can encode. The thread has the priority
of all others: one of lower priority would keep Python's lock from them. PyAV encodes without that lock, but is loaded
with it: that is done before the owner's other threads run.
A failure here ends the video for a while; JPEG pictures do not depend on it.
"""

import logging
import os
import threading
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from robots import bus
from robots.kit.clock import SYSTEM, Timer, Until
from robots.kit.contract.video import FARTHEST, GROUP_S, LONGEST_S, VideoPacket, pack, unpack
from robots.kit.description import CODING
from robots.kit.vision.stability import Picture

log = logging.getLogger(__name__)
ENCODERS = {"vp8": "libvpx", "vp9": "libvpx-vp9"}
QUANTIZER = 34  # of VP8 or VP9, from 0 (best) to 63, if the robot names none
OPTIONS = {"deadline": "good", "cpu-used": "3", "lag-in-frames": "0", "auto-alt-ref": "0"}
FINE = 20  # with a coarser quantizer noise is filtered out first; a finer one keeps everything
ENOUGH = 50_000_000  # bits a second, so that the quantizer alone decides
IDLE_S = 10.0  # without a picture; then the encoder is given up
KEYS_S = 0.5  # between two key frames that were asked for, at least
EARLY_S = 0.1  # a key frame may come so much before its time rather than after it
PAUSE_S = 10.0  # after a failure
FAILED = "the video of camera %d failed; pictures go on as JPEG"


def load() -> None:
    """Load PyAV, 15 MB of memory; where that fails, the video of each camera fails later, and says so."""
    try:
        import av  # noqa: F401, PLC0415 - only an owner with cameras needs it
    except ImportError as error:
        log.warning("no video, pictures go on as JPEG: %s", error)


@dataclass(frozen=True)
class Shot:
    """A picture of shape (rows, columns), or (rows, columns, 3) in blue, green, red; number, still, ms taken."""

    picture: Picture
    number: int
    still: int
    at_ms: int


class Encoder:
    """VP8 or VP9 of constant quality, for pictures of one size."""

    def __init__(self, shape: tuple[int, ...], quantizer: int = QUANTIZER, coding: str = CODING) -> None:
        import av  # noqa: PLC0415 - loaded before, by load()

        self._av: Any = av
        self.shape, self._count = shape, 0
        self._made: Any = self._av.CodecContext.create(ENCODERS[coding], "w")
        self._made.height, self._made.width = shape[:2]
        self._made.pix_fmt, self._made.time_base = "yuv420p", Fraction(1, 100)
        self._made.bit_rate, self._made.qmin, self._made.qmax = ENOUGH, quantizer, quantizer
        self._made.gop_size, self._made.thread_count = 1_000_000, 1
        self._made.color_range = self._av.video.reformatter.ColorRange.JPEG  # which VP9 tells the decoder, too
        self._made.options = OPTIONS | {"noise-sensitivity": "1" if quantizer > FINE else "0"}

    def encode(self, picture: Picture, key: bool) -> tuple[bytes, bool]:
        """Return the coded bytes of the next picture, and whether it stands alone. Raises av.FFmpegError.

        Levels are of the full range, colours by ITU-R BT.601: the browser is told so.
        """
        form = "gray" if picture.ndim == 2 else "bgr24"
        raw = self._av.VideoFrame.from_ndarray(picture, format=form)
        frame = raw.reformat(format="yuv420p", dst_colorspace="ITU601", dst_color_range="JPEG")
        frame.pts, self._count = self._count, self._count + 1
        if key:
            frame.pict_type = self._av.video.frame.PictureType.I
        (packet,) = self._made.encode(frame)
        return bytes(packet), bool(packet.is_keyframe)


class Video:
    """Takes pictures in any thread; encodes and sends the newest in its own."""

    def __init__(
        self, slug: str, camera: int, quantizer: int = QUANTIZER, coarse: bool = False, coding: str = CODING,
        clock: Timer = SYSTEM,
    ) -> None:  # fmt: skip
        self._clock = clock
        self._slug, self._camera, self._coarse = slug, camera, coarse
        self._quantizer, self._coding = quantizer, coding
        self._news = threading.Condition()
        self._shot: Shot | None = None
        self._key = False  # somebody needs a picture that stands alone, and none was encoded since
        self._thread: threading.Thread | None = None
        self._paused_until = 0.0
        self._encoder: Encoder | None = None
        self._run, self._last, self._last_ms = os.urandom(1)[0], 0, 0
        self._key_ms = self._key_bytes = self._bytes = 0  # the newest key frame, and all that follows it

    @property
    def running(self) -> bool:
        """Tell whether pictures were taken lately."""
        return self._thread is not None

    def take(self, shot: Shot, key: bool = False) -> None:
        """Encode this picture next, instead of one that still waits; `key`: somebody needs one that stands alone."""
        with self._news:
            waiting = self._shot
            if self._clock.monotonic() < self._paused_until or (waiting is not None and waiting.number > shot.number):
                return
            self._shot, self._key = shot, key or self._key
            self._news.notify()
            if self._thread is None:
                self._begin()

    def _begin(self) -> None:
        try:  # the thread waits for the lock that the caller holds
            self._thread = self._clock.spawn(self._encode, f"video {self._camera}")
        except RuntimeError:  # the system has no thread left
            log.exception(FAILED, self._camera)
            self._failed()

    def _failed(self) -> None:
        """Make no video for a while; the caller holds the lock."""
        self._paused_until = self._clock.monotonic() + PAUSE_S
        self._shot = self._thread = self._encoder = None
        self._key = False

    def _next(self) -> tuple[Shot, bool] | None:
        """Return the next picture, and whether one must stand alone; None after a while: then the thread ends."""
        with self._news:
            self._clock.wait(Until(self._news, lambda: self._shot is not None), IDLE_S)
            shot, self._shot = self._shot, None
            if shot is None:
                self._thread = self._encoder = None
                return None
            return shot, self._key

    def _encode(self) -> None:
        while (news := self._next()) is not None:
            try:
                self._send(self.packet(*news))
            except Exception:
                log.exception(FAILED, self._camera)
                with self._news:
                    self._failed()
                return

    def _send(self, packet: bytes) -> None:
        bus.publish_video(self._slug, packet, self._camera, self._coarse)
        if unpack(packet).key:
            self._key_made()

    def _key_made(self) -> None:
        """Forget the requests for a key frame that came before it was encoded."""
        with self._news:
            asked, self._key = self._key, False
        if asked:
            bus.end_key_demand(self._slug, self._camera, self._coarse)

    def packet(self, shot: Shot, wants_key: bool = False) -> bytes:
        """Return the packet of the next picture; `wants_key`: soon one that stands alone. Raises av.FFmpegError."""
        key = self._key_due(shot, wants_key) or not 0 < shot.number - self._last <= FARTHEST
        if self._encoder is None or self._encoder.shape != shot.picture.shape:
            self._encoder = Encoder(shot.picture.shape, self._quantizer, self._coding)
            self._run, key = (self._run + 1) & 0xFF, True
        data, stands_alone = self._encoder.encode(shot.picture, key)
        follows = None if stands_alone else self._last
        self._last, self._last_ms = shot.number, shot.at_ms
        made = pack(VideoPacket(self._camera, shot.number, shot.at_ms, shot.still, data, follows, self._run))
        if stands_alone:
            self._key_ms, self._key_bytes, self._bytes = shot.at_ms, len(made), 0
        else:
            self._bytes += len(made)
        return made

    def _key_due(self, shot: Shot, asked: bool) -> bool:
        """Return whether a key frame is due: after 2 s, but later while the changes since are few bytes.

        A newcomer is given all since the last one: so that is at most 2 s, or twice the bytes of a key frame.
        """
        since_s, paused_s = (shot.at_ms - self._key_ms) / 1000, (shot.at_ms - self._last_ms) / 1000
        if since_s < 0 or since_s >= LONGEST_S - EARLY_S or paused_s >= GROUP_S - EARLY_S:
            return True
        return (since_s >= GROUP_S - EARLY_S and self._bytes >= self._key_bytes) or (asked and since_s >= KEYS_S)
