"""One queue: a person who waits to drive sees the jobs that are served before, and the job that runs."""

from datetime import timedelta

import pytest

from queueing import services as queue
from queueing.estimates import place_and_wait
from queueing.models import QueueRobot, Ticket
from queueing.services import Asker, ask, resume, standings
from robots import services
from robots.models import Robot
from robots.states import Cycle
from tests.services.test_jobs import GUEST, OTHER, settle

pytestmark = [pytest.mark.service, pytest.mark.django_db]
HANDOVER_S, LIMIT_S = 12, 20  # of the shuttle's `go`, before any has ended


@pytest.fixture
def stage(shuttle, people, clock):
    """The shuttle is driven too, and is in no state to begin anything."""
    QueueRobot.objects.update(offers_turns=True)
    Robot.objects.update(cycle=Cycle.HANDOVER)
    return Robot.objects.get(), people, clock


def told(ticket, clock):
    """The place and the wait, which must be the same on the robot's page and on every other."""
    ticket.refresh_from_db()
    robot, now = Robot.objects.get(), clock.now()
    everywhere = next(one for one in standings(ticket.user, now) if one.ticket == ticket.pk)
    assert (everywhere.ahead, everywhere.wait_s) == place_and_wait(robot, ticket, now)
    return everywhere.ahead, everywhere.wait_s


def test_jobs_that_were_asked_for_before_count_and_later_ones_do_not(stage):
    shuttle, people, clock = stage
    for asker in (GUEST, OTHER):
        ask(shuttle, asker, "go", {"x": 1.0}, clock.now())
    ada = queue.join(shuttle, people["ada"], clock.go(1))
    late = ask(shuttle, Asker(user=people["bob"]), "go", {"x": 1.0}, clock.go(1))
    assert late.start_tag == ada.start_tag
    assert told(ada, clock) == (2, (0, HANDOVER_S + 2 * LIMIT_S))


def test_who_used_the_robot_much_waits_behind_further_jobs_of_one_who_did_not(stage):
    shuttle, people, clock = stage
    for _ in range(3):
        ask(shuttle, Asker(user=people["bob"]), "go", {"x": 1.0}, clock.now())
    ada = queue.join(shuttle, people["ada"], clock.go(1))
    assert told(ada, clock)[0] == 1, "the others wait behind it, at Ada's tag and later"
    Ticket.objects.update(start_tag=15.0)
    assert told(ada, clock)[0] == 2, "ten seconds each, as far as anybody knows"


def test_the_rest_of_a_running_job_is_part_of_the_wait_and_is_no_place(stage):
    shuttle, people, clock = stage
    Robot.objects.update(cycle=Cycle.READY)
    ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    ada = queue.join(shuttle, people["ada"], clock.go(2))
    assert told(ada, clock) == (0, (0, HANDOVER_S + LIMIT_S - 2))
    settle(clock, seconds=10)
    assert told(ada, clock) == (0, (0, HANDOVER_S)), "and nothing of it once it has ended"


def test_ones_own_jobs_that_gave_way_to_ones_ticket_are_behind_it(stage):
    shuttle, people, clock = stage
    for _ in range(2):
        ask(shuttle, Asker(user=people["ada"]), "go", {"x": 1.0}, clock.now())
    ada = queue.join(shuttle, people["ada"], clock.go(1))
    assert told(ada, clock) == (0, (0, HANDOVER_S))


def test_jobs_that_wait_for_staff_hold_nobody_up(stage):
    shuttle, people, clock = stage
    ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    ada = queue.join(shuttle, people["ada"], clock.go(1))
    services.stop(shuttle, people["kim"], clock.go(1))
    services.release_stop(shuttle, people["kim"], True)
    assert told(ada, clock) == (0, (0, HANDOVER_S))
    resume(shuttle, people["kim"], clock.now() + timedelta(seconds=1))
    assert told(ada, clock)[0] == 1


def test_the_order_that_is_told_is_the_order_in_which_they_are_served(stage):
    shuttle, people, clock = stage
    job = ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    ada = queue.join(shuttle, people["ada"], clock.go(1))
    assert told(ada, clock)[0] == 1
    Robot.objects.update(cycle=Cycle.READY)
    queue.tick(clock.now())
    job.refresh_from_db()
    assert (job.state, told(ada, clock)[0]) == ("running", 0)
