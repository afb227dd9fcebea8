"""Robots, owners and web processes that run on from test to test, because starting them takes long."""

import shutil
import signal
import time  # noqa: TID251 - the limit of a wait

from django.conf import settings
from django.db.models import F

from robots import bus
from robots.kit.clock import SYSTEM
from robots.models import Command, Grant, Lease, Robot
from robots.states import COMMAND_FINAL, Cycle, GrantKind
from tests.faults.wishes import ROBOTS
from tests.rig import Child, Simulator, Web, housekeeping, worker
from tests.store import wipe

SETTLE_S = 20.0
STATE = {
    "id",
    "cycle",
    "reason",
    "stop_latched",
    "stopped_at",
    "stopped_after",
    "stop_confirmed",
    "rests_by",
    "releases",
    "locked_by_id",
}  # what an owner and services change


class House:
    """At most one robot with its simulator and owner, one web process and one housekeeping."""

    def __init__(self) -> None:
        self.sim: Simulator | None = None
        self.owner: Child | None = None
        self.web: Web | None = None
        self.housekeeper: Child | None = None
        self._robot: Robot | None = None
        self._web_env: dict[str, str] = {}

    def robot(self, slug: str) -> Robot | None:
        """Return the robot that is kept running, if it is this one."""
        return self._robot if self._robot is not None and self._robot.slug == slug else None

    def simulator_of(self, robot: Robot) -> Simulator:
        """Return the simulator of a robot, which is started if it does not run."""
        if self.robot(robot.slug) is None:
            self.leave()
            shutil.rmtree(settings.VAR / "run", ignore_errors=True)
            shutil.rmtree(robot.rig_dir, ignore_errors=True)
            robot.rig_dir.mkdir(parents=True)
            Robot.objects.update(cycle=Cycle.OFFLINE)
            self._robot = Robot.objects.get(pk=robot.pk)
            self.sim = ROBOTS[robot.driver].simulator(robot.rig_dir)
        return self.sim

    def owner_of(self, robot: Robot) -> Child:
        """Return the process that owns a robot."""
        self.simulator_of(robot)
        if self.owner is None:
            self.owner = worker(robot.slug)
        return self.owner

    def web_process(self, **env: str) -> Web:
        """Return a web process with this environment."""
        if self.web is not None and (not self.web.alive() or env != self._web_env):
            self.close_web()
        if self.web is None:
            self.web, self._web_env = Web(**env), env
        return self.web

    def housekeeping(self) -> Child:
        """Return a housekeeping process."""
        if self.housekeeper is None or not self.housekeeper.alive():
            self.housekeeper = housekeeping()
        return self.housekeeper

    def settle(self) -> None:
        """Bring the robot to rest and forget what a test has made; close what cannot be brought to rest."""
        kept = None
        try:
            kept = self._at_rest() if self._robot is not None else None
        finally:
            if kept is None:
                self.leave()
            wipe(kept)
            if kept is not None:  # a handover whose grant is wiped fails, and is tried again ten seconds later
                Robot.objects.filter(pk=kept).update(cycle=Cycle.HANDOVER)

    def _at_rest(self) -> int | None:
        robot = Robot.objects.filter(pk=self._robot.pk)
        whole = self.owner is not None and self.owner.alive() and self.sim.process.poll() is None
        if not whole or not Lease.objects.filter(robot=self._robot, pid=self.owner.pid).exists():
            return None
        self.sim.clear()
        robot.filter(stop_latched=True).update(stop_latched=False, releases=F("releases") + 1)
        robot.update(cycle=Cycle.LOCKED_OUT)  # nobody is offered it, and no handover begins
        Grant.objects.filter(robot=self._robot, ended_at=None).exclude(kind=GrantKind.HANDOVER).update(
            ended_at=SYSTEM.now(), end_reason="the test is over"
        )
        until = time.monotonic() + SETTLE_S
        while self._busy():
            if time.monotonic() > until or not self.owner.alive():
                return None
            time.sleep(0.05)
        first = {
            f.attname: getattr(self._robot, f.attname) for f in Robot._meta.concrete_fields if f.attname not in STATE
        }
        robot.update(**first, reason="", locked_by=None, stopped_at=None, stopped_after=None)
        self._robot.queue_link.queue.__class__.objects.update(virtual_time=0.0, greatest_finish=0.0, paused=False)
        self.sim.forget()
        store = bus.connection()
        if gone := [key for key in store.scan_iter() if not key.startswith(b"_kombu")]:  # whom the queues go to
            store.delete(*gone)
        return self._robot.pk

    def _busy(self) -> bool:
        latched = (settings.VAR / "run" / f"{self._robot.slug}.stopped").exists()
        commands = Command.objects.exclude(state__in=COMMAND_FINAL)
        grants = Grant.objects.filter(robot=self._robot, ended_at=None)  # a handover comes to its end
        alive = Lease.objects.filter(robot=self._robot, expires_at__gt=SYSTEM.now()).exists()
        return latched or not alive or self.sim.status()["moving"] or commands.exists() or grants.exists()

    def leave(self) -> None:
        """Stop the robot's processes and housekeeping; the web process serves whatever rows there are."""
        for child in (self.housekeeper, self.owner):
            if child is not None:
                child.signal(signal.SIGCONT)
                child.kill()
        if self.sim is not None:
            self.sim.stop()
        self._robot = self.sim = self.owner = self.housekeeper = None

    def close_web(self) -> None:
        """Stop the web process."""
        if self.web is not None:
            self.web.kill()
        self.web = None

    def close(self) -> None:
        """Stop everything."""
        self.leave()
        self.close_web()


HOUSE = House()
