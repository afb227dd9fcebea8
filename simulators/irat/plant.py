"""The robot's body in the maze, with its range sensors and the dock's contacts."""

from math import cos, pi, sin

import numpy as np

from robots.kit.description import load
from simulators.common.rovers.body import Body, Pose
from simulators.irat import scene
from simulators.irat.dock import DOCKED_M, touching
from simulators.irat.maze import DOCK

NOISE_M = 0.002  # of a range sensor
SENSOR_Z = 0.05


def docked() -> Pose:
    """Return the pose of a robot that stands in the dock (m, m, rad)."""
    x, y, heading = DOCK
    return x + cos(heading) * DOCKED_M, y + sin(heading) * DOCKED_M, heading + pi


class Plant(Body):
    """See `Body`."""

    FREE, HELD = scene.FREE, 0.1  # with more the physics is unstable

    def __init__(self, pose: Pose, with_maze: bool = True, seed: int = 1) -> None:
        description = load("irat")
        self._range = description["range"]
        self._dice = np.random.default_rng(seed)
        self.dead = 0  # range sensors without power, a bit each: left, ahead, right
        super().__init__(scene.spec(with_maze), scene.WHEELS, float(description["body"]["wheel_radius"]), pose)

    def _set_friction(self, share: float) -> None:
        for name in (
            "board",
            *(f"{wheel}_rim" for wheel in scene.WHEELS),
        ):  # of two touching surfaces the rougher counts
            self._model.geom_friction[self._model.geom(name).id, 0] = scene.GRIP[0] * share

    @property
    def contacts(self) -> tuple[bool, bool]:
        """Return which of the dock's two springs the robot's discs touch."""
        return touching(DOCK, self.pose)

    def ranges(self) -> tuple[float, float, float]:
        """Return what the infrared sensors read, left, ahead and right (m)."""
        near, far, (ahead, aside) = self._range["near"], self._range["far"], self._range["from"]
        readings = []
        for number, angle in enumerate(self._range["angles"]):
            length = far if self.dead & 1 << number else self.ray((ahead, aside, SENSOR_Z), angle)[0]
            length += NOISE_M * self._dice.standard_normal() if length < far else 0.0
            readings.append(float(min(max(length, near), far)))
        return readings[0], readings[1], readings[2]
