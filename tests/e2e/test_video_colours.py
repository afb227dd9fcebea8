"""Video on a page with several cameras, each in its own canvas, colours and size; and a robot that sends none."""

import itertools
import threading
import time

import numpy as np
import pytest

from robots import bus
from robots.kit.packets import picture_packet
from tests.conftest import wait_for
from tests.e2e.bare import portal as portal
from tests.e2e.test_pace import Heard
from workers.media.steps import jpeg
from workers.media.video import Shot, Video

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

STRIPES = {0: ((250, 20, 10), (60, 200, 40), (255, 255, 255)), 1: ((10, 30, 250), (0, 0, 0), (240, 220, 20))}
SIZE = (240, 320)
PIXELS = """(canvas) => {
  const context = canvas.getContext("2d");
  return { size: [canvas.height, canvas.width], pixels: [1, 3, 5].map((sixth) =>
    [...context.getImageData((canvas.width * sixth) / 6, canvas.height / 2, 1, 1).data].slice(0, 3)) };
}"""


class Cameras:
    """Encodes stripes as the arm's owner would, five times a second."""

    def __init__(self, slug):
        self._over, self._slug = threading.Event(), slug
        self._videos = [Video(slug, camera) for camera in STRIPES]
        self._thread = threading.Thread(target=self._film, daemon=True)
        self._thread.start()

    def _film(self):
        number = 0
        while not self._over.wait(0.2):
            number += 1
            for camera, stripes in STRIPES.items():
                picture = np.zeros((*SIZE, 3), np.uint8)
                for n, (red, green, blue) in enumerate(stripes):
                    picture[:, n * SIZE[1] // 3 : (n + 1) * SIZE[1] // 3] = (blue, green, red)
                shot = Shot(picture, number, 0, int(time.time() * 1000))
                bus.publish_video(self._slug, self._videos[camera].packet(shot), camera)

    def stop(self):
        self._over.set()
        self._thread.join()


@pytest.fixture
def cameras(bare):
    made = Cameras(bare.robots["pa10"].slug)
    yield made
    made.stop()


def near(found, wanted):
    return found["size"] == list(SIZE) and np.abs(np.subtract(found["pixels"], wanted)).max() <= 12


def test_each_camera_is_shown_in_its_own_colours_and_place(cameras, bare, visitor):
    page = visitor().page
    page.goto(f"/robots/{bare.robots['pa10'].slug}/")
    screen = page.locator("#picture")
    for camera, stripes in STRIPES.items():
        small = page.locator(f"#views [data-view='{camera}'] canvas")
        page.locator(f"#views [data-view='{camera}']").click()
        for canvas in (screen, small):
            wait_for(
                lambda canvas=canvas, stripes=stripes: (
                    page.wait_for_timeout(100) or near(canvas.evaluate(PIXELS), stripes)
                ),
                15,
                f"the colours of camera {camera}",
            )


def test_levels_of_grey_of_a_robot_whose_video_is_vp9(bare, visitor):
    page, slug, over = visitor().page, bare.robot.slug, threading.Event()
    picture = np.repeat(np.array([[3, 128, 250]], np.uint8), 64, axis=1).repeat(165, axis=0)
    video = Video(slug, 0, 12, coding="vp9")

    def film():
        number = 0
        while not over.wait(0.2):
            number += 1
            bus.publish_video(slug, video.packet(Shot(picture, number, 0, int(time.time() * 1000))))

    thread = threading.Thread(target=film, daemon=True)
    thread.start()
    try:
        heard = Heard(page)
        page.goto(f"/robots/{slug}/")
        wanted = [[level] * 3 for level in (3, 128, 250)]
        wait_for(
            lambda: (
                page.wait_for_timeout(100)
                or np.abs(np.subtract(page.locator("#picture").evaluate(PIXELS)["pixels"], wanted)).max() <= 4
            ),
            15,
            "the levels",
        )
        assert heard.wishes()[-1]["video"] == "vp9", "decoded, not JPEG instead"
    finally:
        over.set()
        thread.join()


def test_a_page_whose_robot_sends_no_video_goes_back_to_jpeg(bare, visitor):
    page = visitor().page
    heard, slug = Heard(page), bare.robot.slug
    page.goto(f"/robots/{slug}/")
    wait_for(
        lambda: page.wait_for_timeout(100) or any("video" in wish for wish in heard.wishes()), 10, "a wish for video"
    )
    wait_for(lambda: page.wait_for_timeout(100) or "video" not in heard.wishes()[-1], 15, "a wish for JPEG")
    picture = jpeg(np.full((165, 192), 200, np.uint8))
    number = itertools.count(1)

    def seen():
        """Send one more: the portal may not yet have asked for pictures when the page has."""
        bus.publish_picture(slug, picture_packet(next(number), int(time.time() * 1000), 0, (), picture))
        page.wait_for_timeout(100)
        return page.evaluate(
            "() => document.getElementById('picture').getContext('2d').getImageData(9, 9, 1, 1).data[0] > 190"
        )

    wait_for(seen, 30, "the picture")
