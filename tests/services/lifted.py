"""A robot with its owner in one thread, whose driver counts whatever moves it."""

import os
import shutil

from django.conf import settings

from queueing import services as queue
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import LineGone
from robots.models import Lease, Robot
from tests.services.owner import Arm, followed
from workers.process.wiring import Owner


class Bench(Arm):
    """A driver that counts its motions; its cable can be pulled, and something can happen during a motion."""

    def __init__(self):
        super().__init__()
        self.moves, self.pulled = [], False

    def connect(self):
        if self.pulled:
            raise LineGone("The port vanished.")
        return self.latest()

    state = connect

    def close(self):
        return None

    def execute(self, kind, args, permit, on_stage):
        permit()
        self.moves.append(kind)
        return super().execute(kind, args, permit, on_stage)

    def recover(self, permit):
        permit()
        self.moves.append("reset")
        return self.latest()


class World:
    """One robot, its owner, the queue and the staff, on one clock."""

    def __init__(self, robot, clock, monkeypatch):
        self.robot, self.clock, self.driver, self.owner = robot, clock, Bench(), None
        monkeypatch.setattr(type(SYSTEM), "now", lambda _: clock.now())
        monkeypatch.setattr("robots.bus.may_be_watched", lambda slug: True)
        shutil.rmtree(settings.VAR / "run", ignore_errors=True)
        Lease.objects.get_or_create(robot=robot)
        self.begin()

    @property
    def row(self):
        return Robot.objects.get(pk=self.robot.pk)

    def begin(self):
        """Start the owner; one that ran before is dead."""
        self.end()
        made = Owner(self.robot.slug, self.clock, on_lost=lambda: None)
        made.lease.measure_offset = lambda: None
        made.owned.age = lambda state: self.clock.t - state.at
        made.owned._open_session = lambda: self.driver
        made.owned.driver, made.owned.running, made.pictures.cameras = self.driver, True, []
        assert made.lease._try()
        made.link.note_answer()
        self.owner = made
        made.stopping.begin()
        made.connection.begin()

    def end(self):
        """Kill the owner."""
        if self.owner is not None:
            os.close(self.owner.lease._descriptor)
            self.owner = None
            self.clock.go(60)

    def goes_on(self, rounds, apart_s=1.0):
        """Let the loops of the owner and the queue go round."""
        owner, left = self.owner, rounds

        def round_over(_seconds):
            nonlocal left
            self.clock.go(apart_s)
            owner.link.note_answer()
            owner.lease.renew()
            followed(owner)
            owner.follower.follow_grant()
            queue.tick(self.clock.now())
            owner.lane.beat = self.clock.monotonic()
            left -= 1
            owner.owned.running = left > 0

        owner.lane.sleep = round_over
        owner.control.loop()
        owner.owned.running = True
