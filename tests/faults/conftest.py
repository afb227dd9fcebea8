import json
import shutil
import signal
import uuid
from datetime import timedelta

import pytest
from django.conf import settings
from django.contrib.auth.models import Permission
from django.db import connection

from accounts.models import Clearance
from portal.keep.seeding import add_robot
from portal.run.processes import robot_processes
from robots import bus, services
from robots.grants import owner_alive
from robots.kit.clock import SYSTEM
from robots.models import Command, Grant, Lease, Robot
from robots.states import COMMAND_FINAL, Cycle, GrantKind
from tests.conftest import wait_for
from tests.faults.controls import LOST, Controls
from tests.faults.here import WebHere
from tests.faults.proxy import Proxy
from tests.faults.wishes import ROBOTS
from tests.faults.witness import Witness  # noqa: TID251 - a fixture for timed tests
from tests.looked import swept
from tests.rig import Child, free_port, worker


class Rig:
    """One robot with its simulator and owner, which run on for the next test; or with workers of the test's own."""

    def __init__(self, robot, people, redis_server, house):
        self.robot, self.people, self.redis, self._house = robot, people, redis_server, house
        self.workers = []
        self.wishes = ROBOTS[robot.driver]
        self._own_sim = None
        self.share = None  # of full speed, for robots that take it with each target
        self.proxies = []
        self._controls = None
        if self.wishes.by_staff:
            for name in ("ada", "bob"):
                people[name] = self.made_staff(people[name])

    @staticmethod
    def made_staff(person):
        """Make somebody staff who may change robots; return them anew."""
        person.user_permissions.add(Permission.objects.get(codename="change_robot"))
        person.is_staff = True
        person.save()
        return type(person).objects.get(pk=person.pk)  # which has read no permissions yet

    @property
    def sim(self):
        return self._own_sim or self._house.simulator_of(self.robot)

    @sim.setter
    def sim(self, simulator):
        self._own_sim = simulator

    def own(self):
        """Have a simulator of the test's own, which nobody has owned yet."""
        self._house.leave()
        folder = self.robot.rig_dir
        shutil.rmtree(folder, ignore_errors=True)
        shutil.rmtree(settings.VAR / "run", ignore_errors=True)
        folder.mkdir(parents=True)
        Lease.objects.filter(robot=self.robot).delete()
        Grant.objects.filter(robot=self.robot, ended_at=None).update(
            ended_at=SYSTEM.now(), end_reason="its owner is gone"
        )
        Robot.objects.update(cycle=Cycle.OFFLINE)
        self._own_sim = self.wishes.simulator(folder)

    def start_worker(self, doom="", before=(), **env):
        """Start a worker; a test that begins with one has simulator and workers of its own."""
        if not self.workers and self._own_sim is None:
            self.own()
        child = worker(self.robot.slug, doom=doom, before=before, **env)
        self.workers.append(child)
        return child

    def redis_proxy(self):
        """Return a proxy in front of Redis, and the environment of processes that use it."""
        at = str(settings.VAR / f"redis-{uuid.uuid4().hex[:8]}.sock")
        proxy = Proxy(at, settings.REDIS_URL.removeprefix("unix://"))
        self.proxies.append(proxy)
        return proxy, {"REDIS_URL": f"unix://{at}"}

    def database_proxy(self):
        """Return a proxy in front of PostgreSQL, and the environment of processes that use it."""
        db = connection.settings_dict
        folder = settings.VAR / f"pg-{uuid.uuid4().hex[:8]}"
        folder.mkdir()
        proxy = Proxy(str(folder / ".s.PGSQL.5432"), f"{db['HOST']}/.s.PGSQL.{db['PORT'] or 5432}")
        self.proxies.append(proxy)
        return proxy, {"DATABASE_URL": f"postgres://{db['USER']}:@{str(folder).replace('/', '%2F')}/{db['NAME']}"}

    def line_proxy(self):
        """Return a proxy on the TCP line of a robot that has one, once its owner speaks through it.

        The owner reaches robot and cameras by address, as a real one's would; one that ran before connects anew.
        """
        host, _, port = (self.sim.folder / "tty").read_text().strip().removeprefix("ws://").partition(":")
        proxy = Proxy(("127.0.0.1", free_port()), (host, int(port)))
        self.proxies.append(proxy)
        cameras = self.sim.folder / "cameras.json"
        seen = json.loads(cameras.read_text()).values() if cameras.exists() else ()
        Robot.objects.update(
            address=f"tcp:127.0.0.1:{proxy.at[1]}", camera="\n".join(f"{a}/snapshot.jpg" for a in seen)
        )
        self.owner()
        wait_for(lambda: proxy.carries, 60, "an owner that speaks through the proxy")
        self.wait_ready()
        return proxy

    def owner(self, **env):
        """Have a worker that owns the robot, and wait until it has put it in order."""
        if env:
            child = self.start_worker(**env)
        else:
            child = self._house.owner_of(self.robot)
            self.workers.append(child)
        self.wait_ready()
        return child

    def wait_ready(self, seconds=60):
        def ready():
            assert any(w.alive() for w in self.workers), self.workers[-1].said()
            return self.cycle() == Cycle.READY and owner_alive(self.lease(), SYSTEM.now())

        wait_for(ready, seconds, f"the robot is ready (is {self.cycle()}: {self.reason()})")

    def swept(self):
        """Wait until the owner has looked at the rows and runs no command; what it has not begun, it will not."""
        swept(self.robot)

    def cycle(self):
        return Robot.objects.values_list("cycle", flat=True).get(pk=self.robot.pk)

    def reason(self):
        return Robot.objects.values_list("reason", flat=True).get(pk=self.robot.pk)

    def now(self):
        return SYSTEM.now()

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
        spelt, args = self.wishes.spell(kind, args, self.share)
        issued = services.issue(robot.slug, self.people[who], spelt, args, seq)
        if issued.created and spelt != kind and robot.spec().command(spelt).held:
            self.controls.hold(issued.command, self.wishes.moment_s / (self.share or 1.0))
        return issued.command

    @property
    def controls(self):
        if self._controls is None:
            self._controls = Controls(self.robot.slug)
        return self._controls

    def final(self, command, seconds=30):
        def ended():
            command.refresh_from_db()
            return command.state in COMMAND_FINAL

        wait_for(ended, seconds, f"the end of {command} (is {Command.objects.get(pk=command.pk).state})")
        return command

    def done(self, kind, seconds=30, **args):
        """Return a command that has ended; of a held motion that a machine which stalled has ended, the next one."""
        for _ in range(5):
            command = self.final(self.issue(kind, **args), seconds)
            if command.state != "cancelled" or not command.reason.startswith(LOST):
                return command
        raise AssertionError(f"{kind}: not within five attempts, because the machine stalled")

    def slow(self, share=0.05):
        """Let motions take long, from now on: the owner has read the row. Somebody must have had a turn."""
        self.share = share
        Robot.objects.filter(pk=self.robot.pk).update(settings={"speed": share})
        self.swept()

    def motions(self, *commands):
        """Return the simulator's own notes of the motions towards where these commands asked to go."""
        goals = {self.wishes.goal(c) for c in commands}
        return [r for r in self.wishes.motions(self.sim.journal()) if self.wishes.made(r) in goals]

    def moving(self, seconds=20):
        self.robot_shows(lambda status: status["moving"], seconds, "a motion")

    def robot_shows(self, condition, seconds, what):
        """Wait until the simulator's status meets a condition; say what became of the commands if it does not."""
        try:
            wait_for(lambda: condition(self.sim.status()), seconds, what)
        except AssertionError as error:
            told = [f"{c}: {c.state} {c.reason}" for c in Command.objects.all()]
            raise AssertionError(f"{error}; {told}; {self.cycle()} {self.reason()}") from error

    def close(self):
        if self._controls is not None:
            self._controls.close()
        for child in self.workers:
            child.signal(signal.SIGCONT)
            if child.alive() and child is not self._house.owner:
                child.kill()
        if self._own_sim is not None:
            self._own_sim.stop()
        for proxy in self.proxies:
            proxy.close()
        self._house.settle()


@pytest.fixture
def witness(stopwatch):
    made = Witness()
    yield made
    made.stop()


@pytest.fixture
def rig(transactional_db, redis_server, robot, people, house):
    if house.robot(robot.slug) is None:
        bus.connection().flushall()
    made = Rig(robot, people, redis_server, house)
    yield made
    if redis_server.process is None:
        redis_server.start()
    made.close()


@pytest.fixture
def web(transactional_db, redis_server, robot, people):
    """The web process inside this one, with robot and people."""
    bus.connection().flushall()
    made = WebHere()
    yield made
    made.stop()


@pytest.fixture
def turntable(transactional_db, redis_server, people, installed):
    """Start the turntable with its owner, in ada's turn, its simulator with `env`; return its row and the processes."""
    children = []

    def start(**env):
        bus.connection().flushall()
        robot = add_robot("turntable")
        shutil.rmtree(settings.VAR / "run", ignore_errors=True)
        simulator = next(p for p in robot_processes(robot) if p.name.endswith("robot"))
        children.append(Child("turntable-robot", list(simulator.argv), **simulator.env, **env))
        children.append(worker("turntable"))
        wait_for(lambda: Robot.objects.get(pk=robot.pk).cycle == Cycle.READY, 60, "the robot is in order")
        Clearance.objects.create(user=people["ada"], robot=robot, granted_at=SYSTEM.now())
        services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), people["ada"])
        Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.OPERATING)
        return robot, children

    yield start
    for child in children[::-1]:
        child.kill()
