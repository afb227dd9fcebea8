"""Camera sources: a snapshot address, or anything that PyAV can open."""

import contextlib
import http.client
import json
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol
from urllib.parse import urlsplit

import cv2
import numpy as np
from numpy.typing import NDArray

from robots import addresses
from robots.drivers.errors import CameraFault
from workers.cameras.response import answer_within

Picture = NDArray[np.uint8]
OfDriver = Callable[[str, float], bytes | None]
TIMEOUT_S = 2.0
LARGEST = 4_000_000
ANSWER = answer_within(2 * TIMEOUT_S, TIMEOUT_S)


class Source(Protocol):
    """A source of pictures of shape (rows, columns), or (rows, columns, 3) for colour."""

    def grab(self, exposure_s: float | None) -> Picture:
        """Return a picture whose exposure began after this call; None lets the camera choose. Raises CameraFault."""

    def close(self) -> None:
        """Release the camera."""


class SnapshotCamera:
    """A network camera with a snapshot address that takes an `exposure` in seconds."""

    def __init__(self, url: str, colour: bool = False) -> None:
        self._parts, self._colour = urlsplit(url), colour
        self._connection: http.client.HTTPConnection | None = None

    def grab(self, exposure_s: float | None) -> Picture:
        """Request one picture; try once more if the kept connection was closed. Raises CameraFault."""
        for attempt in (1, 2):
            try:
                return decode(self._fetch(exposure_s), self._colour)
            except (OSError, http.client.HTTPException) as error:
                self.close()
                if attempt == 2 or isinstance(error, TimeoutError):
                    raise CameraFault("The camera does not answer.") from error
        raise CameraFault("The camera does not answer.")

    def _fetch(self, exposure_s: float | None) -> bytes:
        if self._connection is None:
            made = http.client.HTTPSConnection if self._parts.scheme == "https" else http.client.HTTPConnection
            self._connection = made(self._parts.netloc, timeout=TIMEOUT_S)
            self._connection.response_class = ANSWER
            try:
                addresses.check_resolved(self._connection.host, self._connection.port)
                self._connection.connect()
                addresses.check_host(str(self._connection.sock.getpeername()[0]))  # before anything is sent
            except addresses.AddressError as error:
                self.close()
                raise CameraFault(str(error)) from error
        wanted = [] if exposure_s is None else [f"exposure={exposure_s:.6f}"]
        query = "&".join([*filter(None, [self._parts.query]), *wanted])
        self._connection.request("GET", f"{self._parts.path or '/'}{'?' if query else ''}{query}")
        answer = self._connection.getresponse()
        try:
            body = answer.read(LARGEST)
        finally:
            whole = answer.isclosed()  # closed by its last byte
            answer.close()
        if not whole:
            self.close()  # the rest would be taken for the beginning of the next picture
        if answer.status != 200:
            raise CameraFault(f"The camera answered with status {answer.status}.")
        return body

    def close(self) -> None:
        """Close the connection."""
        if self._connection is not None:
            self._connection.close()
            self._connection = None


def decode(data: bytes, colour: bool = False) -> Picture:
    """Return a JPEG or PNG as grey or blue-green-red picture. Raises CameraFault."""
    how = cv2.IMREAD_COLOR if colour else cv2.IMREAD_GRAYSCALE
    try:
        picture = cv2.imdecode(np.frombuffer(data, np.uint8), how) if data else None
    except cv2.error:  # an impossible size
        picture = None
    if picture is None:
        raise CameraFault("The camera sent data that is not a picture.")
    return np.asarray(picture, np.uint8)


def fitted(picture: Picture, width: int, height: int) -> Picture:
    """Return the middle of the picture, cut and scaled to `width` x `height` (px).

    A camera's own resolution may differ from the robot's description and may change while it runs; clicks and
    calibration count in the pixels of the description.
    """
    rows, columns = picture.shape[:2]
    if (columns, rows) == (width, height):
        return picture
    scale = min(columns / width, rows / height)
    w, h = max(1, round(width * scale)), max(1, round(height * scale))
    left, top = (columns - w) // 2, (rows - h) // 2
    cut = picture[top : top + h, left : left + w]
    how = cv2.INTER_AREA if scale > 1 else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(cut, (width, height), interpolation=how), np.uint8)


class DriverCamera:
    """A camera whose pictures come over the robot's own wire; `of_driver(view, seconds)` returns the next one."""

    def __init__(self, of_driver: OfDriver, view: str, colour: bool = False) -> None:
        self._of_driver, self._view, self._colour = of_driver, view, colour

    def grab(self, exposure_s: float | None) -> Picture:
        """Return the first picture that the driver hears from now on. Raises CameraFault."""
        data = self._of_driver(self._view, TIMEOUT_S)
        if data is None:
            raise CameraFault("The camera does not answer.")
        return decode(data, self._colour)

    def close(self) -> None:
        """Release nothing; the driver has the wire."""


class StreamCamera:
    """A USB camera, RTSP or motion JPEG, decoded in a thread that keeps only the newest picture."""

    def __init__(self, source: str, form: str | None = None, colour: bool = False) -> None:
        self._source, self._form = source, form
        self._pixels = "bgr24" if colour else "gray"
        self._news = threading.Condition()
        self._newest: Picture | None = None
        self._at = 0.0
        self._error = ""
        self._ended = threading.Event()
        threading.Thread(target=self._read, daemon=True, name="camera-stream").start()

    def _read(self) -> None:
        import av  # noqa: PLC0415 - 12 MB that a robot without such a camera need not keep

        while self._running:
            try:
                with self._open() as container:
                    self._follow(container)
            except (av.FFmpegError, OSError, ValueError, LookupError) as error:
                self._error = str(error)
            self._ended.wait(0.5)

    def _follow(self, container: Any) -> None:
        """Keep the newest picture; packets without one are read one by one, so that `close` ends the loop soon."""
        for packet in container.demux(container.streams.video[0]):
            for frame in packet.decode():
                picture = frame.to_ndarray(format=self._pixels)
                with self._news:
                    self._newest, self._at, self._error = picture, time.monotonic(), ""
                    self._news.notify_all()
            if not self._running:
                return

    def _open(self) -> Any:
        import av  # noqa: PLC0415

        parts = urlsplit(self._source)
        options = {}
        if parts.hostname:
            addresses.check_resolved(parts.hostname, parts.port or 80)
            options = addresses.http_options(parts.scheme)
        return av.open(self._source, format=self._form, options=options, timeout=(TIMEOUT_S, TIMEOUT_S))

    def grab(self, exposure_s: float | None) -> Picture:
        """Return the first picture that arrives from now on; the camera chooses the exposure. Raises CameraFault."""
        since = time.monotonic()
        with self._news:
            while self._newest is None or self._at <= since:
                if not self._news.wait(TIMEOUT_S):
                    raise CameraFault("The camera does not answer.")
            return self._newest

    def close(self) -> None:
        """Stop the thread."""
        self._ended.set()

    @property
    def _running(self) -> bool:
        return not self._ended.is_set()


def open_camera(url: str, rig: Path, view: str = "", colour: bool = False) -> Source:
    """Return the camera at an address; an empty address means the simulated camera `view` of `rig`.

    Raises:
        CameraFault: the simulated camera has not announced its address yet.
    """
    if not url:
        with contextlib.suppress(OSError, ValueError, KeyError):
            several = rig / "cameras.json"
            if view and several.exists():
                return SnapshotCamera(json.loads(several.read_text())[view] + "/snapshot.jpg", colour)
            return SnapshotCamera((rig / "camera").read_text().strip() + "/snapshot.jpg", colour)
        raise CameraFault("The simulated camera has not started yet.")
    if url.startswith("v4l2:"):
        return StreamCamera(url.removeprefix("v4l2:"), "v4l2", colour)
    if url.startswith("http") and urlsplit(url).path.endswith((".jpg", ".jpeg", ".png")):
        return SnapshotCamera(url, colour)
    return StreamCamera(url, colour=colour)
