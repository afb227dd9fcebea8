"""A picture that is old never looks live: on the landing page and on the robot's own."""

import re
import threading
import time

import cv2
import numpy as np
import pytest
from playwright.sync_api import expect

from robots import bus
from robots.kit.packets import picture_packet
from tests.e2e.bare import portal as portal

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

OWN = re.compile(r"^Picture [\d.]+ s old")


class Camera:
    """Sends a picture ten times a second while it `sees`."""

    def __init__(self):
        self.sees, self._over = True, threading.Event()
        self._thread = threading.Thread(target=self._send, daemon=True)
        self._thread.start()

    def _send(self):
        number = 0
        while not self._over.wait(0.1):
            number += 1
            if self.sees:
                jpeg = cv2.imencode(".jpg", np.full((165, 192, 3), number % 200, np.uint8))[1].tobytes()
                bus.publish_picture("mercury", picture_packet(number, int(time.time() * 1000), 0, (), jpeg))

    def stop(self):
        self._over.set()
        self._thread.join()


@pytest.fixture
def camera(portal):
    made = Camera()
    yield made
    made.stop()


def test_a_frozen_camera_is_marked_on_both_pages_and_live_again_when_it_is(camera, visitor):
    landing = visitor()
    own = landing.new_page()
    landing.page.goto("/")
    own.goto("/robots/mercury/")
    card, badge = landing.page.locator("[data-live=mercury]"), own.locator("#age")

    def live(timeout):
        expect(card).to_have_attribute("data-picture", "live", timeout=timeout)
        expect(card.locator("img")).to_have_attribute("alt", re.compile("sees now$"))
        expect(card.locator(".not-live")).to_have_count(0)
        expect(badge).to_have_attribute("data-age", "fresh", timeout=timeout)

    live(30_000)
    camera.sees = False
    expect(card).to_have_attribute("data-picture", "old", timeout=30_000)
    expect(card.locator("img")).to_have_attribute("alt", re.compile("saw last$"))
    expect(card.locator(".not-live")).to_have_text("Not live")
    expect(badge).to_have_attribute("data-age", "old", timeout=30_000)
    expect(badge).to_have_text(OWN)
    camera.sees = True
    live(30_000)
