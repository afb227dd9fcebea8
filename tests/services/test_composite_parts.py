"""Motion JPEG: what players of films read, and the stored picture with which a camera's stream begins."""

import asyncio
import io
from datetime import timedelta

import av
import cv2
import numpy as np
import pytest
from django.test import RequestFactory

from portal.web.composites import views
from portal.web.composites.parts import GONE_S, HEAD, multipart, part_of
from robots.kit.clock import SYSTEM
from robots.models import Frame

JPEGS = [cv2.imencode(".jpg", np.full((48, 64, 3), grey, np.uint8))[1].tobytes() for grey in (40, 120, 200)]


def answer(jpegs):
    """Return the pieces of an answer whose robot shows these pictures and is gone then."""

    async def parts():
        for jpeg in jpegs:
            yield part_of(jpeg)

    async def all_of():
        return [piece async for piece in multipart(parts())]

    return asyncio.run(all_of())


def test_an_answer_that_ends_has_no_empty_part():
    with av.open(io.BytesIO(b"".join(answer(JPEGS))), format="mpjpeg") as container:
        greys = [int(frame.to_ndarray(format="gray").mean()) for frame in container.decode(video=0)]
    assert greys == pytest.approx([40, 120, 200, 200], abs=3), "the last picture stands once more"
    assert answer([]) == []


def test_each_picture_comes_with_the_head_of_the_next_at_which_browsers_show_it():
    pieces = answer(JPEGS)
    assert pieces[0].startswith(HEAD)
    assert all(piece.endswith(HEAD) for piece in pieces[:-1])


@pytest.mark.service
@pytest.mark.django_db
@pytest.mark.parametrize(("age_s", "shown"), [(0.0, True), (GONE_S - 1, True), (GONE_S + 1, False), (86_400.0, False)])
def test_an_old_still_does_not_pass_for_live(robot, settings, tmp_path, age_s, shown):
    settings.MEDIA_ROOT = tmp_path
    (tmp_path / "still.jpg").write_bytes(JPEGS[0])
    Frame.objects.create(robot=robot, taken_at=SYSTEM.now() - timedelta(seconds=age_s), file="still.jpg")
    assert views._newest_still(robot.slug) == (JPEGS[0] if shown else b"")


@pytest.mark.service
@pytest.mark.django_db
@pytest.mark.parametrize(("method", "limit", "status"), [("post", "", 405), ("head", "", 200), ("get", "COMPOSITES", 429)])  # fmt: skip
def test_who_gets_no_stream_has_no_picture_read(robot, settings, monkeypatch, method, limit, status):
    settings.LIMITS = settings.LIMITS | ({limit: 0} if limit else {})
    looked = views.LiveRobot(robot.slug, robot.spec(), 1, True)

    async def look(slug):
        return looked

    monkeypatch.setattr(views, "sync_to_async", lambda function: look)
    read = []
    monkeypatch.setattr(views, "_newest_still", read.append)
    request = getattr(RequestFactory(), method)("/robots/mercury/camera/0.mjpg")
    assert asyncio.run(views.camera(request, robot.slug, 0)).status_code == status
    assert read == []
