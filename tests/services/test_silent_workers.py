"""An outage is an incident: a worker that is silent for long opens one, which is closed when the robot is back."""

from datetime import timedelta

import pytest

from robots import services
from robots.kit.clock import SYSTEM
from robots.models import Incident, Lease, Robot
from robots.services.incidents import TRANSIENT, incident
from robots.services.outages import CODE, LONG, OVER
from robots.states import Cycle

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.usefixtures("owned")]
MINUTE = timedelta(minutes=1)


@pytest.fixture
def now():
    return SYSTEM.now()


def silent(since):
    Lease.objects.update(expires_at=since)


def answers(now):
    Lease.objects.update(expires_at=now + timedelta(days=1))


def looks(now, minutes):
    """Look each minute. Return the time of the last look."""
    for n in range(minutes + 1):
        services.note_outages(now + n * MINUTE)
    return now + minutes * MINUTE


def test_a_worker_that_is_started_again_is_no_outage(robot, now):
    silent(now)
    looks(now, 1)
    answers(now)
    looks(now + 2 * MINUTE, 3)
    assert not Incident.objects.exists()
    assert Robot.objects.get().silent_since is None


def test_a_worker_that_is_silent_for_long_is_one_incident_which_is_closed_when_it_is_back(robot, now):
    silent(now)
    later = looks(now, 10)
    one = Incident.objects.get()
    assert (one.robot, one.code, one.at, one.closed_at) == (robot, CODE, now, None)
    answers(later)
    services.note_outages(later + MINUTE)
    one.refresh_from_db()
    assert one.closed_at == later + MINUTE
    assert one.remedy.endswith(OVER)
    silent(later)
    looks(later + 2 * MINUTE, 5)
    assert Incident.objects.count() == 2, "the next outage is another incident"


def test_a_robot_that_was_off_for_a_week_has_its_time_to_begin(robot, now):
    silent(now - timedelta(days=7))
    services.note_outages(now)
    services.note_outages(now + LONG / 2)
    assert not Incident.objects.exists()


def test_a_robot_that_is_switched_off_has_no_outage(robot, people, now):
    silent(now)
    later = looks(now, 3)
    services.set_enabled(robot, people["kim"], False)
    services.note_outages(later + MINUTE)
    assert Incident.objects.get().closed_at == later + MINUTE
    looks(later + 2 * MINUTE, 5)
    assert Incident.objects.count() == 1


def test_a_locked_out_robot_has_its_outages_too(robot, people, now):
    services.lock_out(robot, people["kim"], "cleaning")
    silent(now)
    later = looks(now, 3)
    assert Incident.objects.get().closed_at is None
    answers(later)
    services.note_outages(later)
    assert Incident.objects.get().closed_at == later


@pytest.mark.parametrize("remedy", TRANSIENT)
def test_an_incident_of_a_lost_line_is_closed_when_the_robot_is_in_order_again(robot, now, remedy):
    one = incident(robot, "hardware_fault", "The arm does not answer.", now, remedy=remedy)
    Robot.objects.update(cycle=Cycle.FAULT, reason="The arm does not answer.")
    services.note_outages(now)
    assert Incident.objects.get(pk=one.pk).closed_at is None
    Robot.objects.update(cycle=Cycle.READY, reason="")
    services.note_outages(now + MINUTE)
    assert Incident.objects.get(pk=one.pk).closed_at == now + MINUTE


def test_an_incident_that_needs_staff_stays_open(robot, now):
    incident(robot, "stop_failed", "The stop was not confirmed.", now)
    incident(robot, "hardware_fault", "Range error.", now, remedy="Reset; back at its previous position.")
    looks(now, 3)
    assert not Incident.objects.exclude(closed_at=None).exists()


def test_the_clock_may_be_set_back_meanwhile(robot, now):
    silent(now - timedelta(hours=3))
    looks(now, 1)
    services.note_outages(now - timedelta(hours=2))
    assert not Incident.objects.exists()
    looks(now - timedelta(hours=2) + MINUTE, 3)
    assert Incident.objects.count() == 1


def test_the_minutely_task_looks_for_outages(robot, now):
    from workers.process.tasks import online

    silent(now)
    Robot.objects.update(silent_since=now - LONG)
    online()
    assert Incident.objects.get().code == CODE
