"""A stop that only the owner received ends the running job, and nothing starts by itself until staff resume."""

import pytest

from queueing import services as queue
from queueing.models import Job
from queueing.services import ask, resume
from robots import services
from robots.models import Grant, Lease, Robot
from robots.states import Cycle, GrantEnd
from tests.services.owner import followed, made_owner
from tests.services.test_jobs import GUEST, OTHER

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]


@pytest.fixture
def owner(shuttle, people):
    """The owner of a robot that has begun the first of two jobs."""
    Lease.objects.all().delete()
    made = made_owner(shuttle, people)
    now = made.owned.now
    services.end_grant(Grant.objects.get(), GrantEnd.FINISHED, "test", now())
    Robot.objects.update(cycle=Cycle.READY)
    made.motion.before, made.connection.connected = None, True
    made.stopping.begin()
    for asker in (GUEST, OTHER):
        ask(shuttle, asker, "go", {"x": 1.0}, now())
    queue.tick(now())
    assert states() == ["running", "waiting"]
    return made


def states():
    return list(Job.objects.order_by("id").values_list("state", flat=True))


def ticked(owner):
    """Let time go by, and the queue and the owner do what is due."""
    owner.clock.go(1.0)
    owner.lease.renew()
    owner.link.note_answer()
    owner.follower.follow_grant()
    queue.tick(owner.owned.now())
    owner.motion.run_due()
    queue.tick(owner.owned.now())


def pressed(owner):
    owner.stopping.halt("bus")


@pytest.mark.parametrize("when", ["it moves", "it waits"])
def test_the_job_ends_as_stopped_although_the_queue_looks_before_the_owner_follows(owner, people, when):
    if when == "it moves":
        owner.owned.driver.on_the_way = lambda: pressed(owner)
    else:
        pressed(owner)
    ticked(owner)
    assert states() == ["cancelled", "waiting"]
    assert Job.objects.earliest("id").reason == "The robot was stopped."
    followed(owner)
    owner.owned.driver.on_the_way = lambda: None
    robot = owner.owned.robot
    services.release_stop(robot, people["kim"], checked=True)
    followed(owner)
    assert not owner.latch.latched
    ticked(owner)
    assert states() == ["cancelled", "waiting"], "a release starts nothing"
    resume(robot, people["kim"], owner.clock.go(1.0))
    ticked(owner)
    assert states() == ["cancelled", "done"]


def test_a_stop_in_the_row_keeps_its_time_and_one_that_was_released_is_not_written_again(owner, people):
    robot = owner.owned.robot
    pressed(owner)
    services.stop(robot, people["kim"], owner.owned.now(), sent=True)
    at = Robot.objects.get().stopped_at
    owner.clock.go(1.0)
    owner.stopping.note()
    assert Robot.objects.get().stopped_at == at
    services.release_stop(robot, people["kim"], checked=True)
    owner.stopping.note()
    assert not Robot.objects.get().stop_latched
