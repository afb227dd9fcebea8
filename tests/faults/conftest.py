import shutil
import signal
from datetime import timedelta

import pytest
from django.conf import settings

from robots import bus, services
from robots.clock import SYSTEM
from robots.models import Command, Lease, Robot
from robots.states import COMMAND_FINAL, Cycle, GrantKind
from tests.conftest import wait_for
from tests.rig import Simulator, worker


class Rig:
    """One robot with its simulator and any number of workers."""

    def __init__(self, robot, people, redis_server):
        self.robot, self.people, self.redis = robot, people, redis_server
        self.workers = []
        Robot.objects.update(cycle=Cycle.OFFLINE)
        folder = robot.rig_dir
        shutil.rmtree(folder, ignore_errors=True)
        shutil.rmtree(settings.VAR / "run", ignore_errors=True)
        folder.mkdir(parents=True)
        self.sim = Simulator(folder)

    def start_worker(self, **env):
        child = worker(**env)
        self.workers.append(child)
        return child

    def owner(self):
        """Start a worker and wait until it owns the robot and has put it in order."""
        child = self.start_worker()
        self.wait_ready()
        return child

    def wait_ready(self, seconds=40):
        def ready():
            assert any(w.alive() for w in self.workers), self.workers[-1].said()
            return self.cycle() == Cycle.READY and services.owner_alive(self.lease(), SYSTEM.now())

        wait_for(ready, seconds, f"the robot is ready (is {self.cycle()}: {self.reason()})")

    def cycle(self):
        return Robot.objects.values_list("cycle", flat=True).get(pk=self.robot.pk)

    def reason(self):
        return Robot.objects.values_list("reason", flat=True).get(pk=self.robot.pk)

    def lease(self):
        return Lease.objects.filter(robot=self.robot).first()

    def grant(self, who="ada", seconds=300):
        now = SYSTEM.now()
        Robot.objects.filter(pk=self.robot.pk).update(cycle=Cycle.OPERATING)
        return services.start_grant(self.robot, GrantKind.TURN, now, self.people[who], now + timedelta(seconds=seconds))

    def issue(self, kind, who="ada", seq=None, **args):
        robot = Robot.objects.get(pk=self.robot.pk)
        grant = services.open_grant(robot)
        seq = seq or services.next_seq(grant)
        return services.issue(robot, self.people[who], kind, args, seq).command

    def final(self, command, seconds=30):
        def ended():
            command.refresh_from_db()
            return command.state in COMMAND_FINAL

        wait_for(ended, seconds, f"the end of {command} (is {Command.objects.get(pk=command.pk).state})")
        return command

    def moving(self, seconds=10):
        wait_for(lambda: self.sim.status()["moving"], seconds, "a motion")

    def close(self):
        for child in self.workers:
            if child.alive():
                child.signal(signal.SIGCONT)
                child.kill()
        self.sim.stop()


@pytest.fixture
def rig(transactional_db, redis_server, robot, people):
    bus.connection().flushall()
    made = Rig(robot, people, redis_server)
    yield made
    made.close()
    if redis_server.process is None:
        redis_server.start()
