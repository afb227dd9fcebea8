"""An idle portal costs little: a queue with nothing open is ticked every fifth second, any other every second."""

from datetime import timedelta

import pytest

from queueing import services as queue
from queueing.models import Ticket
from queueing.tick import busy_queues, tick_seldom
from robots.grants import end_grant, start_grant
from robots.models import Lease, Robot
from robots.states import Cycle, GrantEnd, GrantKind

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.fixture
def stage(robot, people, clock):
    Lease.objects.update_or_create(robot=robot, defaults={"epoch": 1, "expires_at": clock.now() + timedelta(days=99)})
    Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.READY)
    return queue.queue_of(robot), people["ada"], clock


def test_a_queue_is_busy_while_anything_in_it_is_open(stage, robot):
    mine, ada, clock = stage
    assert not busy_queues().exists()
    queue.join(robot, ada, clock.now())
    assert list(busy_queues()) == [mine]
    Ticket.objects.all().delete()
    assert not busy_queues().exists()
    grant = start_grant(robot, GrantKind.UPKEEP, clock.now(), until=clock.now() + timedelta(seconds=5))
    assert list(busy_queues()) == [mine]
    end_grant(grant, GrantEnd.TIME_UP, "time is up", clock.now())
    assert not busy_queues().exists()
    for cycle in (Cycle.OFFERED, Cycle.OPERATING, Cycle.HANDOVER):
        Robot.objects.filter(pk=robot.pk).update(cycle=cycle)
        assert list(busy_queues()) == [mine], cycle


def test_who_joins_is_offered_the_robot_within_a_second_and_a_quiet_queue_is_looked_at_seldom(
    stage, robot, django_assert_num_queries
):
    _, ada, clock = stage
    quiet = clock.now().replace(second=1)
    with django_assert_num_queries(1):
        tick_seldom(quiet)
    queue.join(robot, ada, quiet)
    tick_seldom(quiet + timedelta(seconds=1))
    assert Ticket.objects.get().state == "offered"
