"""Privacy masks: set by staff, applied before a picture is published or stored, so that nothing that follows shows more."""

import json
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from django.conf import settings as configured

from robots.kit.clock import SYSTEM
from robots.kit.contract.session import RobotState
from tests.services.test_settings import address, admin, form, sent
from workers.media.camera import Camera
from workers.media.pictures import Pictures

pytestmark = [pytest.mark.django_db, pytest.mark.parametrize("which", ["srv1"], indirect=True)]
assert admin  # a fixture
ALL = SimpleNamespace(jpeg=True, video=True, coarse=True, coarse_video=True)  # what viewers ask for
LEFT, RIGHT = [[0, 0, 0, 160, 240]], [[0, 160, 0, 320, 240]]
WHITE = cv2.imencode(".png", np.full((240, 320, 3), 255, np.uint8))[1].tobytes()
STATE = RobotState(0.0, (), (1.0, 1.0, 0.0), False, True)


def seen(picture):
    """Return how bright the left and the right half are."""
    return round(float(picture[:, :150].mean())), round(float(picture[:, 170:].mean()))


def test_a_changed_mask_counts_from_the_next_picture_on(robot):
    robot.settings = {"privacy_masks": LEFT}
    camera = Camera(robot, 0, "rover", lambda view, seconds: WHITE)
    assert seen(camera.grab(None)) == (0, 255)
    robot.settings = {"privacy_masks": RIGHT}
    camera.configure(robot)
    assert seen(camera.grab(None)) == (255, 0)
    robot.settings = {"privacy_masks": "what nobody can read"}
    camera.configure(robot)
    assert seen(camera.grab(None)) == (0, 0)
    assert seen(Camera(robot, 1, "other", lambda view, seconds: WHITE).grab(None)) == (0, 0)


def test_pictures_are_masked_before_they_are_stored_or_published(robot, settings, tmp_path, monkeypatch):
    settings.MEDIA_ROOT = tmp_path
    robot.settings = {"privacy_masks": LEFT}
    eyes = Pictures(robot, SYSTEM, lambda view, seconds: WHITE)
    stored = eyes.photograph(STATE)
    assert seen(cv2.imread(str(configured.MEDIA_ROOT / stored["file"]))) == (0, 255)
    sent = []
    monkeypatch.setattr("workers.media.pictures.bus.demands", lambda slug, camera: ALL)
    monkeypatch.setattr(eyes._steps[0], "due", lambda wanted, now: ALL)
    monkeypatch.setattr(eyes._steps[0], "send", lambda due, shot, *rest: sent.append(shot.picture))
    assert eyes.live_once(STATE)
    assert [seen(picture) for picture in sent] == [(0, 255)]


def test_staff_set_masks_in_the_admin_and_what_is_none_is_refused_in_words(robot, admin):
    assert admin.post(address(robot), sent(robot, privacy_masks=json.dumps(LEFT))).status_code == 302
    robot.refresh_from_db()
    assert robot.settings == {"privacy_masks": LEFT}
    assert "privacy_masks" not in robot.driver_settings(), "the driver hides nothing"
    assert json.loads(form(admin, robot)["setting_privacy_masks"].value()) == LEFT
    answer = admin.post(address(robot), sent(robot, privacy_masks="[[0, 9, 0, 3, 3]]"))
    assert "A privacy mask is [camera, x0, y0, x1, y1]" in answer.text
