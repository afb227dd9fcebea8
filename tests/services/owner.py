"""An owner without its threads, on a fake clock, with a driver that needs no wire."""

import shutil
import threading
from datetime import timedelta

from django.conf import settings
from django.db import connections

from robots import services
from robots.kit.contract.session import Outcome, RobotState
from robots.models import Lease, Robot
from robots.states import Cycle, GrantKind
from tests.conftest import FakeClock
from workers.process.wiring import Owner


class Arm:
    """A driver whose motion begins, asks its permit once more, and ends."""

    def __init__(self):
        self.holds, self.on_the_way = 0, lambda: None

    def latest(self):
        return RobotState(0.0, (0.0,) * 7, (0.0,) * 6, False, True)

    state = latest

    def rests_within(self):
        return None

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


def begun(function, *args):
    """Start a thread that closes its connections to the database when the function ends; return it."""

    def run():
        try:
            function(*args)
        finally:
            connections.close_all()

    thread = threading.Thread(target=run)
    thread.start()
    return thread


def followed(owner):
    """Let an owner follow the rows of stop and grants once, as its threads `follow` and `hold` do."""
    owner.stopping.follow()
    owner.stopping.hold_due()
    owner.stopping.follow()


def made_owner(robot, people, **options):
    """Return the owner of a robot whose turn is ada's; nothing runs by itself."""
    shutil.rmtree(settings.VAR / "run", ignore_errors=True)
    Robot.objects.update(cycle=Cycle.OPERATING)
    Lease.objects.get_or_create(robot=robot)
    clock = FakeClock()
    made = Owner(robot.slug, clock, **{"on_lost": lambda: None, **options})
    made.lease.measure_offset = lambda: None
    made.owned.age = lambda state: clock.t - state.at  # its drivers stamp their states by the same clock
    made.owned.driver, made.owned.running = Arm(), True
    assert made.lease._try()
    made.link.note_answer()
    made.pictures.cameras = []
    services.start_grant(robot, GrantKind.TURN, clock.now(), people["ada"], clock.now() + timedelta(seconds=60))
    return made
