"""Serves pictures as an ordinary network camera: a snapshot and a motion JPEG stream.

``/snapshot.jpg?exposure=0.0156`` takes one picture now; ``/stream.mjpg`` is the multipart stream that browsers and
video libraries read. A camera may have a microphone: ``/microphone.wav``.
"""

import contextlib
import ctypes
import sys
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from math import isfinite, nan
from typing import Any
from urllib.parse import parse_qs, urlsplit

from robots.kit.brownout import Brownout
from robots.kit.clock import TIMER, WALL, Timer, Wall
from simulators.common.faults import FaultBoard
from simulators.common.microphone import Microphone
from simulators.common.sensor import Sensor, Take

STREAM_S = 0.1
LEAST_OFTEN_S = 1.0  # the longest pause between two pictures: a still that is taken from the stream must not wait long
IDLE_S = 5.0  # without a picture; then the memory that the last ones took is given back
MOST_VIEWERS = 64
SILENT_S = 5.0  # real time: the longest pause between two requests, and the longest wait for a viewer to read on
BOUNDARY = "frame"


class Server(ThreadingHTTPServer):
    """One thread per viewer, for at most 64; a viewer that disconnects during a request is not an error."""

    daemon_threads = True
    request_queue_size = 32
    real: Timer = TIMER
    used_at: float | None = None  # by `real`, when the newest picture was made; None once its memory was given back

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self._free = threading.BoundedSemaphore(MOST_VIEWERS)

    def process_request(self, request: Any, client_address: Any) -> None:
        """Serve a viewer in a thread; close the connection at once where there are too many."""
        if not self._free.acquire(blocking=False):
            self.shutdown_request(request)
            return
        try:
            super().process_request(request, client_address)
        except Exception:  # the system has no thread left for now, say; the server closes the connection
            self._free.release()
            raise

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Serve a viewer to the end of the connection."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._free.release()

    def service_actions(self) -> None:
        """Give back memory once pictures have stopped; called twice a second of real time."""
        if self.used_at is not None and self.real.monotonic() - self.used_at > IDLE_S:
            self.used_at = None
            give_memory_back()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Log an error, unless the viewer's connection was lost, or the viewer did not read on."""
        if not isinstance(sys.exception(), ConnectionError | TimeoutError):
            super().handle_error(request, client_address)


class CameraServer:
    """A camera at `http://127.0.0.1:<port>`; `take(exposure_s)` exposes one picture.

    `clock` is the simulator's. `real` is the machine's: it paces streams, and tells when memory is given back.
    """

    def __init__(
        self, take: Take, faults: FaultBoard, exposure_range: tuple[float, float], clock: Timer = TIMER,
        microphone: Microphone | None = None, real: Timer = TIMER, wall: Wall = WALL,
    ) -> None:  # fmt: skip
        self._sensor, self._faults = Sensor(take, faults, clock, wall), faults
        self._range, self._microphone, self._real = exposure_range, microphone, real
        camera = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"
            timeout = SILENT_S

            def log_message(self, format: str, *args: object) -> None:
                pass

            def do_GET(self) -> None:
                camera.answer(self)

        self._server = Server(("127.0.0.1", 0), Handler)
        self._server.real = real
        self.port = self._server.server_address[1]
        threading.Thread(target=self._server.serve_forever, daemon=True, name="camera").start()

    def answer(self, request: BaseHTTPRequestHandler) -> None:
        """Answer one request."""
        parts = urlsplit(request.path)
        if self._microphone is not None and parts.path == self._microphone.path:
            with contextlib.suppress(ConnectionError):
                self._microphone.answer(request)
            return
        if self._faults.value("cam_gone"):
            request.close_connection = True
            return
        try:
            exposure = float(parse_qs(parts.query).get("exposure", ["0.0067"])[0])
        except ValueError:
            exposure = nan
        if not isfinite(exposure):
            request.send_error(400, "exposure is not a number")
            return
        exposure = min(max(exposure, self._range[0]), self._range[1])
        try:
            if parts.path == "/snapshot.jpg":
                self._snapshot(request, exposure)
            elif parts.path == "/stream.mjpg":
                self._stream(request, exposure)
            else:
                request.send_error(404)
        except (BrokenPipeError, ConnectionResetError):
            request.close_connection = True

    def _snapshot(self, request: BaseHTTPRequestHandler, exposure: float) -> None:
        body = self._picture(exposure)
        request.send_response(200)
        request.send_header("Content-Type", "image/jpeg")
        request.send_header("Content-Length", str(len(body)))
        request.send_header("Cache-Control", "no-store")
        request.send_header("X-Frame-Count", str(self._sensor.count))
        request.end_headers()
        request.wfile.write(body)

    def _stream(self, request: BaseHTTPRequestHandler, exposure: float) -> None:
        request.send_response(200)
        request.send_header("Content-Type", f"multipart/x-mixed-replace; boundary={BOUNDARY}")
        request.send_header("Connection", "close")
        request.end_headers()
        request.close_connection = True
        brownout = Brownout()
        while not self._faults.value("cam_gone"):
            body = self._picture(exposure)
            head = f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\nContent-Length: {len(body)}\r\n\r\n"
            request.wfile.write(head.encode() + body + b"\r\n")
            request.wfile.flush()
            wait = min(brownout.every_s(STREAM_S), LEAST_OFTEN_S)
            begun = self._real.monotonic()  # brownout measures how late the machine is
            self._real.sleep(wait)
            brownout.feel(self._real.monotonic() - begun - wait, self._real.monotonic())

    def _picture(self, exposure: float) -> bytes:
        body = self._sensor.picture(exposure)
        self._server.used_at = self._real.monotonic()
        return body


def give_memory_back() -> None:
    """Return all free pages of this process to the system, which glibc keeps; with other C libraries do nothing."""
    with contextlib.suppress(AttributeError):
        ctypes.CDLL(None).malloc_trim(0)
