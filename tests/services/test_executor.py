"""What the owner does when its database goes away while the robot is at something."""

import shutil
from datetime import timedelta

import pytest
from django.conf import settings
from django.db import OperationalError

from robots import services
from robots.drivers.contract import Outcome, RobotState
from robots.drivers.pa10.driver import features
from robots.models import Lease, Robot
from robots.states import Cycle, GrantKind
from tests.conftest import FakeClock
from workers import ledger
from workers.runtime import Runtime

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]


class Arm:
    """A driver whose motion begins, asks its permit once more, and ends."""

    def __init__(self):
        self.features, self.holds, self.on_the_way = features(), 0, lambda: None

    def latest(self):
        return RobotState(0.0, (0.0,) * 7, (0.0,) * 6, False, True)

    state = latest

    def check(self, kind, args, pose=None):
        return None

    def hold(self):
        self.holds += 1
        return self.latest()

    def execute(self, kind, args, permit, on_stage):
        permit()
        on_stage("sent")
        on_stage("acknowledged")
        self.on_the_way()
        permit()
        return Outcome({}, self.latest())


@pytest.fixture
def owner(robot, people):
    shutil.rmtree(settings.VAR / "run", ignore_errors=True)
    Robot.objects.update(cycle=Cycle.OPERATING)
    Lease.objects.get_or_create(robot=robot)
    clock = FakeClock()
    made = Runtime(robot.slug, clock, on_lost=lambda: None)
    made.lease.measure_offset = lambda: None
    made.driver, made.running = Arm(), True
    assert made.lease._try()
    made.gate.link_seen = clock.monotonic()
    made.pictures.eyes = []
    services.start_grant(robot, GrantKind.TURN, clock.now(), people["ada"], clock.now() + timedelta(seconds=60))
    return made


def run(owner, people):
    command = services.issue(owner.robot.slug, people["ada"], "ready", {}, 1, owner.now()).command
    owner._one(command)
    command.refresh_from_db()
    return command


@pytest.mark.parametrize("which", ["pa10"], indirect=True)
def test_a_newer_target_that_cannot_be_read_breaks_nothing_off(owner, people, monkeypatch):
    def gone(robot, epoch):
        raise OperationalError("gone")

    def ring():
        owner.look()
        monkeypatch.setattr(ledger, "due", gone)

    owner.driver.on_the_way = ring
    assert run(owner, people).state == "completed"


@pytest.mark.parametrize("which", ["pa10"], indirect=True)
def test_what_breaks_off_in_mid_motion_is_held_and_its_end_is_unknown(owner, people):
    def gone():
        raise OperationalError("gone")

    owner.driver.on_the_way = gone
    command = run(owner, people)
    assert owner.driver.holds == 1
    assert (command.state, "Look at the new picture" in command.reason) == ("unknown", True)
    assert ledger.tidy(owner.robot, owner.lease.epoch, owner.now()) == 0
