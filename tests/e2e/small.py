"""A portal of one robot, whose driver and simulator come from a package."""

import shutil

from django.conf import settings

from portal.run.processes import robot_processes
from robots import bus
from robots.models import Robot
from robots.states import Cycle
from tests.conftest import wait_for
from tests.rig import Child, Web, housekeeping


class SmallPortal:
    """Web process, housekeeping and the robot with its owner. `env`: settings of the web process."""

    def __init__(self, robot, ready_s=60, **env):
        bus.connection().flushall()  # what robots of other tests have told
        shutil.rmtree(settings.VAR / "run", ignore_errors=True)
        self.robot = robot
        specs = robot_processes(robot)
        self._children = [Child(p.name.replace(" ", "-"), list(p.argv), **p.env) for p in specs]
        self.web = Web(**env)
        self._children += [housekeeping(), self.web]
        self.url = self.web.url
        try:
            wait_for(lambda: Robot.objects.get(pk=robot.pk).cycle == Cycle.READY, ready_s, "the robot is in order")
        except AssertionError:
            self.stop()
            raise

    def stop(self):
        for child in self._children[::-1]:
            child.kill()
