"""Fixtures of the tests in virtual time."""

import gc
import shutil
from contextlib import ExitStack
from datetime import UTC, datetime

import pytest
from django.conf import settings
from django.contrib.auth.models import Permission

from accounts.models import Clearance
from operatorlog.models import SurveyQuestion
from queueing.models import Account, Job, Queue, QueueRobot, Ticket
from robots.models import Command, Grant, Incident, Lease, Robot
from tests.conftest import CALIBRATION
from tests.packaged import ERRANDS, installed_from
from tests.world.delays import NONE
from tests.world.pa10 import ArmRig
from tests.world.portal import Portal
from tests.world.puma import PumaRig

FOLDER = settings.VAR / "world"  # of the simulator, which writes its place while it moves: in memory


@pytest.fixture
def worlds(transactional_db, robot, people):
    """Begin a world with a robot, its owner and its supervisor; the one before is closed.

    A world is full of cycles, some 20 MB that would stay until the collector looks by itself. What outlives the last
    one, modules and caches, the collector need not look at again.
    """
    with ExitStack() as opened:

        def begin(seed: int, delays=NONE) -> Portal:
            opened.close()
            gc.collect()
            wipe_doings(robot, people)
            shutil.rmtree(FOLDER, ignore_errors=True)
            made = Portal(seed, robot, people, FOLDER, delays)
            opened.callback(made.close)
            if made.wishes.by_staff:
                ada = people["ada"]
                ada.is_staff = True
                ada.save()
                ada.user_permissions.add(Permission.objects.get(codename="change_robot"))
                people["ada"] = type(ada).objects.get(pk=ada.pk)  # which has read no permissions yet
            return made

        yield begin
    gc.collect()
    gc.freeze()


@pytest.fixture
def errands(monkeypatch):
    """Install a Mercury arm that is also asked for jobs."""
    with installed_from(ERRANDS, monkeypatch):
        yield


@pytest.fixture
def sharp(monkeypatch):
    """Let an arm's pictures be as large as its cameras', so that objects can be recognised."""
    for rig in (PumaRig, ArmRig):
        monkeypatch.setattr(rig, "width", None)


@pytest.fixture
def crowds(worlds, robot, people, django_user_model):
    """Begin worlds, as `worlds`, in which four people may drive, and are asked afterwards."""
    for name in ("cy", "dan"):
        people[name] = django_user_model.objects.create_user(name, f"{name}@example.org", "correct horse 42")
        Clearance.objects.create(user=people[name], robot=robot, granted_at=datetime(2025, 1, 1, tzinfo=UTC))
    SurveyQuestion.objects.create(prompt="How was it?")
    Robot.objects.filter(pk=robot.pk).update(calibration=CALIBRATION)
    return worlds


def wipe_doings(robot, people) -> None:
    """Remove what a run before has made."""
    for model in (Command, Grant, Incident, Lease, Job, Ticket, Account):
        model.objects.all().delete()
    Queue.objects.update(virtual_time=0.0, greatest_finish=0.0)
    QueueRobot.objects.update(watched_at=None, resumed_at=None)
    type(people["ada"]).objects.filter(is_active=False).update(is_active=True)
    Robot.objects.filter(pk=robot.pk).update(lockout_note="", locked_by=None)
