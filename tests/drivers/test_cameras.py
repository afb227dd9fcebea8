"""Cameras over HTTP: a snapshot, a motion JPEG through PyAV, and every way to fail."""

import http.server
from threading import Thread
from urllib.request import urlopen

import cv2
import numpy as np
import pytest

from robots.kit.contract.errors import CameraFault
from robots.kit.vision.stability import settle
from tests.conftest import wait_for
from workers.media import video
from workers.media.source import SnapshotCamera, StreamCamera, fitted, open_camera

pytestmark = pytest.mark.timed


@pytest.fixture
def url(sim):
    return (sim.folder / "camera").read_text().strip()


@pytest.fixture
def camera(url):
    camera = SnapshotCamera(url + "/snapshot.jpg")
    yield camera
    camera.close()


def test_a_snapshot_is_grey_and_of_the_papers_size(camera):
    picture = camera.grab(1 / 150)
    assert picture.shape == (165, 192)
    assert picture.dtype == np.uint8
    assert 60 < picture.mean() < 190
    assert not np.array_equal(picture, camera.grab(1 / 150)), "a sensor has noise"


def test_a_longer_exposure_is_brighter(camera):
    assert camera.grab(1 / 64).mean() > camera.grab(1 / 200).mean() + 5


def test_pyav_reads_the_motion_jpeg_as_it_would_a_network_camera(sim, url):
    video.load()  # as the owner does first; the camera's first picture is limited to two seconds
    camera = open_camera(url + "/stream.mjpg", sim.folder)
    assert isinstance(camera, StreamCamera)
    first, second = camera.grab(0.01), camera.grab(0.01)
    assert first.shape == (165, 192)
    assert not np.array_equal(first, second)
    camera.close()

    def served():
        return [name for name in sim.status()["threads"] if name.startswith("Thread-")]  # one answers this

    wait_for(lambda: len(served()) <= 1, 10, "the end of the stream, whose pictures others would miss")


@pytest.mark.parametrize(("verb", "reason"), [("cam_freeze", "frozen"), ("cam_black", "black"), ("cam_flicker", "unstable")])  # fmt: skip
def test_a_bad_camera_never_counts_as_stable_and_always_answers(sim, camera, verb, reason):
    camera.grab(0.01)
    sim.fault(verb, seed=2)
    verdict = settle(lambda: camera.grab(1 / 64), 0.9)
    assert not verdict.stable
    assert verdict.reason in (reason, "black")


def test_a_camera_that_is_gone_is_a_fault_and_comes_back(sim, camera):
    camera.grab(0.01)
    sim.fault("cam_gone")
    with pytest.raises(CameraFault, match="does not answer"):
        camera.grab(0.01)
    sim.clear()
    assert camera.grab(0.01).shape == (165, 192)


def test_a_camera_slower_than_the_limit_is_a_fault(sim, camera):
    sim.fault("cam_slow", 5 * sim.speed)
    with pytest.raises(CameraFault):
        camera.grab(0.01)


def test_no_simulated_camera_yet(tmp_path):
    with pytest.raises(CameraFault, match="has not started yet"):
        open_camera("", tmp_path)


def _read(url):
    with urlopen(url, timeout=10) as answer:
        return answer.read()


def test_many_can_look_at_once(sim, url):
    sizes = []
    threads = [Thread(target=lambda: sizes.append(len(_read(url + "/snapshot.jpg")))) for _ in range(6)]
    for t in threads:
        t.start()
    for t in threads:
        t.join(10)
    assert len(sizes) == 6
    assert min(sizes) > 1000


@pytest.mark.parametrize(("rows", "columns"), [(165, 192), (480, 640), (82, 96), (1080, 1920), (1, 1), (300, 20)])
def test_any_size_becomes_the_described_one_and_keeps_its_middle(rows, columns):
    picture = np.zeros((rows, columns), np.uint8)
    r = rows // 40
    picture[rows // 2 - r : rows // 2 + r + 1, columns // 2 - r : columns // 2 + r + 1] = 255
    shown = fitted(picture, 192, 165)
    assert shown.shape == (165, 192)
    if min(rows, columns) > 20:
        v, u = np.unravel_index(int(np.argmax(cv2.blur(shown, (5, 5)))), shown.shape)
        assert abs(u - 96) < 8
        assert abs(v - 82) < 8


class Redirects(http.server.BaseHTTPRequestHandler):
    target, asked = "", []

    def do_GET(self):
        type(self).asked.append(self.path)
        self.send_response(302)
        self.send_header("Location", self.target)
        self.end_headers()

    def log_message(self, *_):
        pass


@pytest.fixture
def redirecting():
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Redirects)
    Redirects.target, Redirects.asked = f"http://127.0.0.1:{server.server_port}/secret", []
    Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()


@pytest.mark.asvs("1.3.6", "15.3.2")
@pytest.mark.parametrize("path", ["/snapshot.jpg", "/stream.mjpg"])
def test_no_redirect_of_a_camera_is_followed(redirecting, tmp_path, path):
    camera = open_camera(redirecting + path, tmp_path)
    try:
        with pytest.raises(CameraFault):
            camera.grab(0.01)
        times = 2 if "stream" in path else 1  # a stream asks again once it has taken the answer
        wait_for(lambda: len(Redirects.asked) >= times, 20, "the camera was asked")
    finally:
        camera.close()
    assert not [p for p in Redirects.asked if p.startswith("/secret")]
