"""A goal that is impossible on the map that the robot shows is refused at the request, in one sentence."""

from datetime import timedelta

import numpy as np
import pytest
from django.test import Client

from queueing.models import Job, QueueRobot
from robots import bus
from robots.kit.contract.streams import StreamPacket, pack
from robots.kit.drivers.irat.packets import DOCK, HEAD, PLACE, UNIT_M, VERSION
from robots.models import Lease, Robot

pytestmark = [pytest.mark.service, pytest.mark.django_db]
MAP = 4


def told(number, places, key, dock=None):
    """Return a packet of the map with experiences `places`: x, y (m) by id."""
    ids, units = np.array(list(places), "<u4"), np.rint(np.array(list(places.values())) / UNIT_M).astype("<i2")
    data = HEAD.pack(VERSION, DOCK if dock else 0, MAP, len(places), 0) + ids.tobytes() + units.T.tobytes()
    data += PLACE.pack(*(round(v / UNIT_M) for v in dock)) if dock else b""
    return pack(StreamPacket(0, number, 1000 + number, key, data))


@pytest.fixture
def rat(robot, people, clock, redis_server):
    """A robot whose spec is the iRat's and that takes goals from guests; it has shown a map and a change of it."""
    Robot.objects.filter(pk=robot.pk).update(driver="irat", calibration={})
    Lease.objects.create(robot=robot, epoch=5, expires_at=clock.now() + timedelta(days=9))
    QueueRobot.objects.filter(robot=robot).update(offers_turns=False, guests_ask=True, charged_in="jobs")
    key = told(1, {1: (0.0, 0.0), 2: (0.3, 0.0)}, True, (0.3, 1.0, 0.42))
    bus.publish_stream(robot.slug, 0, [key, told(2, {2: (0.5, 0.0), 3: (0.3, 0.8)}, False)], True)
    yield robot
    if not bus.alive():
        redis_server.start()
    bus.connection().flushall()


def asked(robot, **args):
    """Ask as a guest, as the page does on a click."""
    values = {f"arg-{name}": str(value) for name, value in ({"map": MAP} | args).items()}
    answer = Client().post(
        f"/robots/{robot.slug}/jobs/", {"kind": "goal"} | values, headers={"accept": "application/json"}
    )
    return answer.status_code, answer.json().get("error", "")


@pytest.mark.parametrize(
    ("args", "why"),
    [
        ({"x": 0.25, "y": 0.0}, "No place on the robot's map is within 0.1 m"),  # 2 was moved by the change
        ({"x": 5.0, "y": 5.0, "experience": 9}, "No place on the robot's map is within 0.1 m"),
        ({"x": 0.0, "y": 0.0, "map": MAP + 1}, "The map was cleared"),
        ({"x": 0.3, "y": 0.8}, "at the dock, where the robot goes only to charge"),
    ],
)
def test_a_goal_that_the_map_does_not_have_is_refused_at_once(rat, args, why):
    status, said = asked(rat, **args)
    assert (status, why in said, said.endswith(".")) == (400, True, True)
    assert Job.objects.count() == 0


@pytest.mark.parametrize("args", [{"x": 0.52, "y": 0.03}, {"x": 0.0, "y": 0.0}, {"x": 5.0, "y": 5.0, "experience": 1}])
def test_a_goal_near_a_place_is_taken(rat, args):
    assert asked(rat, **args) == (201, "")


def test_while_nobody_knows_the_map_the_robot_judges(rat, redis_server):
    bus.connection().flushall()
    assert asked(rat, x=5.0, y=5.0) == (201, "")
    redis_server.stop()
    assert asked(rat, x=5.0, y=5.0) == (201, "")
    assert Job.objects.count() == 2
