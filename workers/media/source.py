"""Camera sources: a snapshot address, or anything that PyAV can open."""

import contextlib
import http.client
import json
import logging
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol
from urllib.parse import SplitResult, quote, urlsplit

import cv2
import numpy as np
from numpy.typing import NDArray

from robots.kit import addresses
from robots.kit.contract.errors import CameraFault
from robots.kit.opening import why_not
from workers.media.login import Login
from workers.media.response import answer_within

log = logging.getLogger(__name__)
Picture = NDArray[np.uint8]
OfDriver = Callable[[str, float], bytes | None]
TIMEOUT_S = 2.0
LARGEST = 4_000_000
AGAIN_S = 0.5  # before a stream is opened again
ANSWER = answer_within(2 * TIMEOUT_S, TIMEOUT_S)
KEPT = "%!$&'()*+,/:;=?@~[]"  # in an address; everything else that is not plain ASCII is percent-encoded as UTF-8
UNREADABLE = "The camera's address cannot be read; write / ? # @ : of its password as %2F %3F %23 %40 %3A."
REFUSED = "The camera refuses the user and the password in its address."
UNKNOWN = "The camera asks for a user and a password: write them into its address, as http://user:password@host/."


def _parts(url: str) -> SplitResult:
    """Return the parts of an address. Raises CameraFault, without what could be a part of a password."""
    try:
        parts = urlsplit(url)
        _ = parts.port
    except ValueError:
        raise CameraFault(UNREADABLE) from None
    return parts


def _because(error: Exception) -> str:
    return f": {why_not(error)}" if isinstance(error, OSError) and not isinstance(error, TimeoutError) else "."


class Source(Protocol):
    """A source of pictures of shape (rows, columns), or (rows, columns, 3) for colour."""

    def grab(self, exposure_s: float | None) -> Picture:
        """Return a picture whose exposure began after this call; None lets the camera choose. Raises CameraFault."""

    def close(self) -> None:
        """Release the camera."""


class SnapshotCamera:
    """A network camera with a snapshot address that takes an `exposure` in seconds."""

    def __init__(self, url: str, colour: bool = False) -> None:
        """Take the address apart; user and password go nowhere but to the camera. Raises CameraFault."""
        parts = _parts(url)
        self._made = http.client.HTTPSConnection if parts.scheme == "https" else http.client.HTTPConnection
        self._host, self._port, self._colour = parts.hostname or "", parts.port or self._made.default_port, colour
        self._path, self._query = (quote(text, safe=KEPT) for text in (parts.path or "/", parts.query))
        self._login = Login(parts)
        self._connection: http.client.HTTPConnection | None = None

    def grab(self, exposure_s: float | None) -> Picture:
        """Request one picture; try once more if the kept connection was closed. Raises CameraFault."""
        for attempt in (1, 2):
            try:
                return decode(self._fetch(exposure_s), self._colour)
            except (OSError, http.client.HTTPException) as error:
                self.close()
                if attempt == 2 or isinstance(error, TimeoutError):
                    raise CameraFault(f"The camera does not answer{_because(error)}") from error
        raise CameraFault("The camera does not answer.")

    def _fetch(self, exposure_s: float | None) -> bytes:
        wanted = [] if exposure_s is None else [f"exposure={exposure_s:.6f}"]
        query = "&".join([*filter(None, [self._query]), *wanted])
        target = f"{self._path}{'?' if query else ''}{query}"
        status, challenges, body = self._ask(target)
        if status == 401 and self._login.challenged(challenges):
            status, _, body = self._ask(target)
        if status == 401:
            raise CameraFault(REFUSED if self._login.has_user else UNKNOWN)
        if status != 200:
            raise CameraFault(f"The camera answered with status {status}.")
        return body

    def _ask(self, target: str) -> tuple[int, list[str], bytes]:
        """Send one request; return the answer's status, its challenges, and its body."""
        connection = self._connection
        if connection is None or connection.sock is None:  # the camera closes each connection
            connection = self._connect()
        connection.request("GET", target, headers=self._login.header(target))
        answer = connection.getresponse()
        try:
            body = answer.read(LARGEST)
        finally:
            whole = answer.isclosed()  # closed by its last byte
            answer.close()
        if not whole:
            self.close()  # the rest would be taken for the beginning of the next picture
        return answer.status, answer.headers.get_all("WWW-Authenticate", []), body

    def _connect(self) -> http.client.HTTPConnection:
        made = self._connection = self._made(self._host, self._port, timeout=TIMEOUT_S)
        made.response_class, made.auto_open = ANSWER, 0  # it would open an address that was not checked
        try:
            addresses.check_resolved(made.host, made.port)
            made.connect()
            addresses.check_host(str(made.sock.getpeername()[0]))  # before anything is sent
        except addresses.AddressError as error:
            self.close()
            raise CameraFault(str(error)) from error
        return made

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
        self._source, self._form, self._parts = source, form, _parts(source)
        self._pixels = "bgr24" if colour else "gray"
        self._news = threading.Condition()
        self._newest: Picture | None = None
        self._at = self._heard = 0.0  # monotonic (s): of the newest picture; of the newest packet, or the attempt
        self._error = ""
        self._ended = threading.Event()
        threading.Thread(target=self._read, daemon=True, name="camera-stream").start()

    def _read(self) -> None:
        while self._running:
            self._heard = time.monotonic()
            try:
                with self._open() as container:
                    self._follow(container)
            except Exception as error:  # whatever a library raises: the thread tries again, and `grab` says why
                log.debug("a camera's stream ended", exc_info=True)
                late = time.monotonic() - self._heard >= TIMEOUT_S
                self._error = f": {why_not(error, '' if '://' in self._source else self._source, late).rstrip('.')}"
            self._ended.wait(AGAIN_S)

    def _follow(self, container: Any) -> None:
        """Keep the newest picture; packets without one are read one by one, so that `close` ends the loop soon."""
        for packet in container.demux(container.streams.video[0]):
            self._heard = time.monotonic()
            for frame in packet.decode():
                picture = frame.to_ndarray(format=self._pixels)
                with self._news:
                    self._newest, self._at, self._error = picture, time.monotonic(), ""
                    self._news.notify_all()
            if not self._running:
                return

    def _open(self) -> Any:
        import av  # noqa: PLC0415 - 12 MB that a robot without such a camera need not keep

        parts, options = self._parts, {}
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
                    raise CameraFault(f"The camera does not answer{self._error}.")
            return self._newest

    def close(self) -> None:
        """Stop the thread."""
        self._ended.set()

    @property
    def _running(self) -> bool:
        return not self._ended.is_set()


OpenCamera = Callable[[str, Path, str, bool], Source]


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
    if url.startswith("http") and _parts(url).path.endswith((".jpg", ".jpeg", ".png")):
        return SnapshotCamera(url, colour)
    return StreamCamera(url, colour=colour)
