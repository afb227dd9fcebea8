"""Read cameras: a network camera's snapshot, or anything PyAV can open."""

import contextlib
import http.client
import threading
import time
from pathlib import Path
from typing import Any, Protocol
from urllib.parse import urlsplit

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from robots.drivers.errors import CameraFault

Picture = NDArray[np.uint8]
TIMEOUT_S = 2.0
LARGEST = 4_000_000


class Camera(Protocol):
    """A source of grey pictures, shape (rows, columns)."""

    def grab(self, exposure_s: float) -> Picture:
        """Return a picture that was begun after this call. Raises CameraFault."""

    def close(self) -> None:
        """Let go of the camera."""


class SnapshotCamera:
    """A network camera with a snapshot address that takes an `exposure` in seconds."""

    def __init__(self, url: str) -> None:
        self._parts = urlsplit(url)
        self._connection: http.client.HTTPConnection | None = None

    def grab(self, exposure_s: float) -> Picture:
        """Ask for one picture; one try more on a connection that had gone stale."""
        for attempt in (1, 2):
            try:
                return decode(self._fetch(exposure_s))
            except (OSError, http.client.HTTPException) as error:
                self.close()
                if attempt == 2 or isinstance(error, TimeoutError):
                    raise CameraFault("The camera does not answer.") from error
        raise CameraFault("The camera does not answer.")

    def _fetch(self, exposure_s: float) -> bytes:
        if self._connection is None:
            made = http.client.HTTPSConnection if self._parts.scheme == "https" else http.client.HTTPConnection
            self._connection = made(self._parts.netloc, timeout=TIMEOUT_S)
        path = f"{self._parts.path or '/'}?{self._parts.query}&exposure={exposure_s:.6f}"
        self._connection.request("GET", path)
        answer = self._connection.getresponse()
        body = answer.read(LARGEST)
        if answer.status != 200:
            raise CameraFault(f"The camera answered with status {answer.status}.")
        return body

    def close(self) -> None:
        """Close the connection."""
        if self._connection is not None:
            self._connection.close()
            self._connection = None


def decode(data: bytes) -> Picture:
    """Return the grey picture in JPEG or PNG bytes. Raises CameraFault."""
    picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE) if data else None
    if picture is None:
        raise CameraFault("The camera sent something that is no picture.")
    return np.asarray(picture, np.uint8)


class StreamCamera:
    """A USB camera, RTSP or motion JPEG, decoded in a thread; only the newest picture is kept."""

    def __init__(self, source: str, form: str | None = None) -> None:
        self._source, self._form = source, form
        self._news = threading.Condition()
        self._newest: Picture | None = None
        self._at = 0.0
        self._error = ""
        self._running = True
        threading.Thread(target=self._read, daemon=True, name="camera-stream").start()

    def _read(self) -> None:
        while self._running:
            try:
                with self._open() as container:
                    for frame in container.decode(video=0):
                        grey = frame.to_ndarray(format="gray")
                        with self._news:
                            self._newest, self._at, self._error = grey, time.monotonic(), ""
                            self._news.notify_all()
                        if not self._running:
                            return
            except (av.FFmpegError, OSError, ValueError) as error:
                self._error = str(error)
            time.sleep(0.5)

    def _open(self) -> Any:
        return av.open(self._source, format=self._form, timeout=(TIMEOUT_S, TIMEOUT_S))

    def grab(self, exposure_s: float) -> Picture:
        """Return the first picture that arrives from now on; the exposure is the camera's own."""
        since = time.monotonic()
        with self._news:
            while self._newest is None or self._at <= since:
                if not self._news.wait(TIMEOUT_S):
                    raise CameraFault("The camera does not answer.")
            return self._newest

    def close(self) -> None:
        """Stop the thread."""
        self._running = False


def open_camera(url: str, rig: Path) -> Camera:
    """Return the camera for an address; empty means the simulated one of `rig`.

    Raises:
        CameraFault: the simulated camera has not said its address yet.

    """
    if not url:
        with contextlib.suppress(OSError):
            return SnapshotCamera((rig / "camera").read_text().strip() + "/snapshot.jpg")
        raise CameraFault("The simulated camera is not there yet.")
    if url.startswith("v4l2:"):
        return StreamCamera(url.removeprefix("v4l2:"), "v4l2")
    if url.startswith("http") and urlsplit(url).path.endswith((".jpg", ".jpeg", ".png")):
        return SnapshotCamera(url)
    return StreamCamera(url)
