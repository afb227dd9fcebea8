"""The motion JPEG of a robot in a browser without scripts, as wide as a phone of the paper's time."""

from datetime import timedelta

import cv2
import numpy as np
import pytest
from django.conf import settings

from portal.keep.seeding import add_robot
from robots.kit.clock import SYSTEM
from robots.models import Frame, Lease, Robot
from tests.conftest import wait_for
from tests.faults.test_composites import PHONE, Teller

pytestmark = pytest.mark.timed


@pytest.fixture
def told(bare):
    """An iRat in the database whose states, pictures and map are told."""
    robot = add_robot("irat")
    Lease.objects.create(robot=robot, epoch=1, expires_at=SYSTEM.now() + timedelta(days=9))
    teller = bare.teller = Teller()
    yield bare
    teller.stop()


def test_a_camera_s_stream_shows_the_newest_still_at_once_though_no_picture_follows(told, chromium):
    """Within the five seconds after which it ends; a browser that waited for the next part would show nothing."""
    robot = Robot.objects.get(slug="irat")
    Frame.objects.create(robot=robot, taken_at=SYSTEM.now(), file="frames/irat/still.jpg")
    file = settings.MEDIA_ROOT / "frames" / "irat" / "still.jpg"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(cv2.imencode(".jpg", np.full((60, 80, 3), 200, np.uint8))[1].tobytes())
    told.teller.sees = False
    page = chromium.new_page(base_url=told.url)
    try:
        page.goto("/robots/irat/camera/0.mjpg", wait_until="commit")
        page.wait_for_function("document.images[0]?.naturalWidth === 80", timeout=4000)
    finally:
        page.close()


def test_the_robots_page_leads_to_it_and_it_moves_without_scripts(told, chromium):
    context = chromium.new_context(base_url=told.url, java_script_enabled=False, viewport={"width": 320, "height": 480})
    try:
        page = context.new_page()
        page.goto("/robots/irat/")
        assert page.get_by_role("link", name="320 x 480").get_attribute("href") == PHONE
        page.goto(PHONE, wait_until="commit")
        page.wait_for_selector("img")
        assert page.locator("img").bounding_box()["width"] == 320
        seen = [page.screenshot()]
        for _ in range(2):
            wait_for(
                lambda: seen.append(page.screenshot()) or page.wait_for_timeout(100) or seen[-1] not in seen[:-1],
                20,
                "the picture moves",
            )
    finally:
        context.close()
