"""A test of cameras that hang, break off, dribble or answer garbage: it ends, says so, and leaves nothing behind."""

import os
import threading
import time
from pathlib import Path

import pytest

from robots.models import Robot
from tests.conftest import wait_for
from tests.services.test_bounded_answers import answering
from workers.housekeeping import probe

# ruff: noqa: TID251 - its tests are timed
pytestmark = [pytest.mark.django_db(transaction=True), pytest.mark.timed]
LONGEST_S = 12.0  # any of them


def hang(line):
    line.recv(4096)
    time.sleep(30)


def break_off(line):
    line.recv(4096)
    line.sendall(b"HTTP/1.1 200 OK\r\nContent-Type: image/jpeg\r\nContent-Length: 100000\r\n\r\n\xff\xd8\xff")


def garbage(line):
    line.recv(4096)
    line.sendall(b"HTTP/1.1 200 OK\r\nContent-Type: video/x-motion-jpeg\r\n\r\n")
    while True:
        line.sendall(os.urandom(4096))
        time.sleep(0.001)


def dribble(line):
    line.recv(4096)
    line.sendall(b"HTTP/1.1 200 OK\r\nContent-Type: image/jpeg\r\nContent-Length: 100000\r\n\r\n")
    while True:
        line.sendall(b"\xff")
        time.sleep(0.2)


def dribble_head(line):
    line.recv(4096)
    while True:
        line.sendall(b"H")
        time.sleep(0.2)


def bomb(line):
    """Send a picture of a few bytes that says it is 60000 points wide and high."""
    line.recv(4096)
    head = b"\xff\xd8\xff\xc0\x00\x0b\x08\xea\x60\xea\x60\x01\x01\x11\x00\xff\xd9"
    line.sendall(b"HTTP/1.1 200 OK\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(head) + head)


FAULTS = (hang, break_off, garbage, dribble, dribble_head, bomb)
ADDRESSES = (
    "http://127.0.0.1:{port}/snapshot.jpg",
    "http://127.0.0.1:{port}/stream.mjpg",
    "rtsp://127.0.0.1:{port}/live",
)


@pytest.fixture
def camera(request):
    """A camera that behaves in the given way, on a port of its own."""

    def answer(line):
        with line:
            request.param(line)

    with answering(answer, "the camera itself") as port:
        yield port


def descriptors():
    return len(list(Path("/proc/self/fd").iterdir()))


def ours():
    return {t for t in threading.enumerate() if t.name != "the camera itself"}


@pytest.mark.asvs("1.4.3", "15.2.2")
@pytest.mark.parametrize("address", ADDRESSES)
@pytest.mark.parametrize("camera", FAULTS, indirect=True, ids=lambda way: way.__name__)
def test_a_probe_of_a_broken_camera_leaves_no_thread(robot, camera, address):
    Robot.objects.update(address="tcp:127.0.0.1:9", camera=address.format(port=camera))
    before, files, begun = ours(), descriptors(), time.monotonic()
    found = probe.probe(Robot.objects.get())
    assert time.monotonic() - begun < LONGEST_S
    assert found["picture"]
    assert found["picture"] != "ok"
    wait_for(lambda: ours() <= before, LONGEST_S, f"the end of {ours() - before}")
    assert descriptors() <= files + 3  # the camera's own ends
