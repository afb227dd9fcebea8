"""The hall rover's jobs in virtual time: a mission that has begun is never begun again by itself."""

from random import Random

import pytest

from queueing import services as queue
from queueing.models import Job, JobState
from queueing.services import Asker, ask
from robots.models import Command
from robots.states import Cycle
from tests.world.seeds import hunts

pytestmark = pytest.mark.parametrize("which", ["srv1"], indirect=True)
MISSION = "turn 90\nturn -90\nturn 90\nread\n"


def ticked(portal, holds, seconds, what):
    """Advance the queues until something holds."""

    def tick():
        queue.tick(portal.world.now())
        return holds()

    portal.until(tick, seconds, what)


def state_of(job):
    return Job.objects.values_list("state", flat=True).get(pk=job.pk)


@hunts(2, 10, 100)
def test_a_mission_that_is_cut_off_is_not_begun_again(portal):
    """Its line is pulled in a step: the job has failed at that step, for nothing; nothing begins it again."""
    portal.ready()
    job = ask(portal.robot, Asker(user=portal.people["ada"]), "mission", {"text": MISSION}, portal.world.now())
    ticked(portal, lambda: portal.rig.moving, 60, "the mission")
    portal.world.sleep(1 + 5 * Random(portal.world.seed).random())
    portal.rig.pull()
    ticked(portal, lambda: state_of(job) != JobState.RUNNING, 60, "its end")
    job.refresh_from_db()
    assert (job.state, job.charged, job.runs.count()) == ("failed", 0.0, 1), job.reason
    assert job.reason.startswith("Step ") and "of 4" in job.reason, job.reason
    portal.rig.plug()
    ticked(portal, lambda: portal.row.cycle == Cycle.READY, 120, "a rover that is in order")
    until = portal.world.monotonic() + 60
    ticked(portal, lambda: portal.world.monotonic() > until, 90, "a minute")
    assert Command.objects.filter(kind="mission").count() == 1, "it was begun again"
    job.refresh_from_db()
    assert (job.state, job.runs.count()) == ("failed", 1)
