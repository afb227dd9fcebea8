"""The admin's test of a connection, through the housekeeping worker as in life."""

import contextlib
import shutil
import socket
import threading
import time
from datetime import timedelta
from pathlib import Path

import pytest
from django.conf import settings
from django.contrib.auth import get_user_model

from queueing import services as queue
from queueing.models import Ticket, TicketState
from robots import bus
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import NotPermitted
from robots.kit.opening import ABSENT, REFUSED
from robots.models import Robot
from robots.services import probes
from tests.conftest import wait_for
from tests.rig import Simulator, housekeeping

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed


@pytest.fixture
def housekeeper(transactional_db, redis_server, robot, people):
    bus.connection().flushall()
    Robot.objects.update(enabled=False)
    shutil.rmtree(robot.rig_dir, ignore_errors=True)
    robot.rig_dir.mkdir(parents=True)
    child = housekeeping()
    yield child
    child.kill()


def probe(robot):
    Robot.objects.filter(pk=robot.pk).update(probe={})
    probes.ask(robot, get_user_model().objects.get(username="kim"), SYSTEM.now())
    found = {}

    def done():
        found.update(Robot.objects.get(pk=robot.pk).probe)
        return bool(found)

    wait_for(done, 60, "the probe")
    return found


def simulators(robot):
    """Return the simulators of this robot that run, as the kernel tells."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):  # it has ended meanwhile
            found.append(path.read_bytes())
    return [line for line in found if str(robot.rig_dir).encode() in line]


def test_a_robot_that_is_switched_off_is_tested_and_left_as_it_was(housekeeper, robot):
    found = probe(robot)
    assert (found["connection"], found["picture"]) == ("ok", "ok")
    assert len(found["state"]["pose"]) == 4
    assert (Path(settings.MEDIA_ROOT) / found["file"]).stat().st_size > 500
    wait_for(lambda: not simulators(robot), 10, "no simulator is left")


def test_what_does_not_answer_is_named(housekeeper, robot):
    Robot.objects.update(address="serial:/dev/ttyNOWHERE", camera="http://127.0.0.1:9/snapshot.jpg")
    found = probe(robot)
    assert found["connection"] == f"The robot's serial port cannot be opened: {ABSENT}"
    assert found["picture"] == f"The camera does not answer: {REFUSED}"


def test_a_controller_that_is_silent_is_named(housekeeper, robot):
    Robot.objects.update(enabled=True)  # so that the probe starts no simulator of its own
    sim = Simulator(robot.rig_dir)
    try:
        sim.fault("awol")
        found = probe(robot)
        assert "did not answer" in found["connection"]
        assert found["picture"] == "ok"
    finally:
        sim.stop()


@pytest.fixture
def silent():
    """A camera's address where somebody listens and says nothing, and who called."""
    server, calls = socket.create_server(("127.0.0.1", 0), backlog=64), []

    def serve():
        while True:
            try:
                calls.append(server.accept()[0])
            except OSError:
                return

    waiting = threading.Thread(target=serve, daemon=True)
    waiting.start()
    yield server.getsockname()[1], calls
    server.shutdown(socket.SHUT_RDWR)  # wakes the thread, which would take one more call of a socket that is closed
    waiting.join()
    server.close()
    for call in calls:
        call.close()


@pytest.mark.asvs("15.2.2")
def test_thirty_tests_that_hang_run_one_by_one_and_delay_no_queue(housekeeper, robot, people, silent):
    port, calls = silent
    many = [
        Robot.objects.create(
            slug=f"r{i}", name=f"R{i}", driver="mercury", address="tcp:127.0.0.1:9",
            camera=f"http://127.0.0.1:{port}/snapshot.jpg",
        )
        for i in range(30)
    ]  # fmt: skip
    for one in many:
        probes.ask(one, people["kim"], SYSTEM.now())
    with pytest.raises(NotPermitted, match="running"):
        probes.ask(many[-1], people["kim"], SYSTEM.now())
    wait_for(lambda: Robot.objects.exclude(probe_begun_at=None).exists(), 30, "the first test")
    Robot.objects.filter(pk=robot.pk).update(enabled=True)
    robot.refresh_from_db()
    late = []
    for name in ("ada", "bob") * 3:  # a tick removes people who were away too long
        ticket = queue.join(robot, people[name], SYSTEM.now())
        Ticket.objects.filter(pk=ticket.pk).update(last_seen=SYSTEM.now() - timedelta(days=1))
        asked = time.monotonic()
        wait_for(lambda pk=ticket.pk: Ticket.objects.get(pk=pk).state == TicketState.EXPIRED, 10, "a tick")
        late.append(time.monotonic() - asked)
        assert Robot.objects.exclude(probe_begun_at=None).count() <= 1, "one at a time"
    assert Robot.objects.exclude(probe_asked_at=None).count() > 10, "they still wait"
    assert max(late) < 5, late
    assert calls
