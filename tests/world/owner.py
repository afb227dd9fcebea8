"""A robot's worker in a world: the real owner with all its threads, and a supervisor that starts it again."""

import threading

from django.db import Error

from robots.models import Lease
from tests.world.world import Killed, World
from workers.authority.processes import Process, Processes
from workers.process.wiring import Owner
from workers.robot.machine import Machine

HOST = "world"


class WorldProcesses(Processes):
    """The processes of a world, as an owner in one of them knows them."""

    def __init__(self, world: World, number: int) -> None:
        self._world, self._number = world, number

    @property
    def own(self) -> Process:
        return Process(HOST, self._number, f"start {self._number}")

    def _lives(self, pid: int, started: str) -> bool:
        return pid in self._world.processes and not self._world.processes[pid].killed

    def _kill(self, pid: int, started: str) -> None:
        self._world.kill(self._world.processes[pid])


class Worker:
    """One process that wants to own a robot, from its start to its end."""

    def __init__(self, world: World, slug: str, rig) -> None:
        self.world, self.rig, self.slug = world, rig, slug
        self.process = world.process("worker")
        self.owner: Owner | None = None
        self._told_to_end = threading.Event()
        world.spawn(self._run, "worker", self.process)

    @property
    def ended(self) -> bool:
        return self.process.killed

    def _run(self) -> None:
        try:
            self._own()
        except Error as error:  # the database is away while it begins: a process ends by that
            self.world.note(f"the worker ended: {error}")
        self._exit()

    def _own(self) -> None:
        machine = Machine(self.rig.session, self.rig.camera, WorldProcesses(self.world, self.process.number))
        made = Owner(self.slug, self.world, on_lost=self._exit, machine=machine)
        self.process.at_kill.append(made.lease.unlock_device)
        if made.own(self._told_to_end.is_set):
            made.start()
            self.owner = made
            self.world.wait(self._told_to_end, float("inf"))
            made.stop()

    def _exit(self) -> None:
        """End the process, as `os._exit` does."""
        self.world.kill(self.process)
        raise Killed

    def terminate(self) -> None:
        """Ask it to end, as SIGTERM does."""
        self._told_to_end.set()

    def kill(self) -> None:
        self.world.kill(self.process)


class Supervisor:
    """Starts a robot's worker again a moment after it has ended."""

    AGAIN_S = 1.0

    def __init__(self, world: World, slug: str, rig) -> None:
        self.world, self._slug, self._rig = world, slug, rig
        self.worker = Worker(world, slug, rig)
        self.starts = 1
        process = world.process("supervisor", delayed=False)
        world.spawn(self._run, "supervisor", process)

    def _run(self) -> None:
        while True:
            self.world.sleep(0.1)
            if self.worker.ended:
                self.world.sleep(self.AGAIN_S)
                self.worker, self.starts = Worker(self.world, self._slug, self._rig), self.starts + 1

    @property
    def owner(self) -> Owner | None:
        """Return the owner that is started, if it lives."""
        return None if self.worker.ended else self.worker.owner

    def lease(self) -> Lease:
        return Lease.objects.get(robot__slug=self._slug)
