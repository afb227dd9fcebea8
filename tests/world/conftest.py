"""Fixtures of the tests in virtual time."""

import shutil
from types import SimpleNamespace

import pytest
from django.conf import settings

from robots import bus
from robots.clock import SYSTEM
from robots.models import Robot
from robots.states import Cycle
from tests.world.delays import NONE
from tests.world.mercury import MercuryRig
from tests.world.owner import Supervisor
from tests.world.store import MemoryStore
from tests.world.world import World

RIGS = {"mercury": MercuryRig}


@pytest.fixture
def worlds(robot, people, tmp_path):
    """Begin a world with a robot, its owner and its supervisor; the one before is closed."""
    from contextlib import ExitStack

    with ExitStack() as open_worlds:

        def begin(seed: int, delays=NONE):
            open_worlds.close()
            made = Portal(seed, delays, robot, people, tmp_path / str(len(list(tmp_path.iterdir()))))
            open_worlds.callback(made.close)
            return made

        yield begin


class Portal(SimpleNamespace):
    """A world with the people side's rows, a store, and one robot with its owner."""

    def __init__(self, seed, delays, robot, people, folder):
        shutil.rmtree(settings.VAR / "run", ignore_errors=True)
        Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.OFFLINE, reason="", stop_latched=False)
        world = World(seed, delays)
        super().__init__(world=world, robot=robot, people=people, store=MemoryStore(world))
        bus.speak_through(self.store)
        self._before = SYSTEM.live_by(world)
        self.rig = RIGS[robot.driver](world, folder)
        self.supervisor = Supervisor(world, robot.slug, self.rig)

    @property
    def owner(self):
        return self.supervisor.owner

    def close(self):
        try:
            self.world.close()
            self.world.check_errors()
        finally:
            self.rig.close()
            SYSTEM.live_by(self._before)
            bus.speak_through(None)
