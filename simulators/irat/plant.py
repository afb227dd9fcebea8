"""The robot's body in the maze: takes rim speeds, returns wheels, ranges, contacts and, for judges only, its pose."""

from math import atan2, cos, pi, sin

import mujoco
import numpy as np
from numpy.typing import NDArray

from robots.kit.description import load
from simulators.irat import scene
from simulators.irat.dock import DOCKED_M, touching
from simulators.irat.maze import DOCK

Floats = NDArray[np.float64]
Pose = tuple[float, float, float]
TICK_S = 0.02
STEPS = round(TICK_S / scene.STEP_S)
STILL_RAD_S, STILL_M_S = 0.05, 0.002  # below this wheels and hull rest
NOISE_M = 0.002  # of a range sensor
FREE, HELD = 1e-4, 0.1  # damping of a wheel, free and blocked (N m s/rad); with more the physics is unstable
SENSOR_Z = 0.05
LEAST_GRIP = 0.002  # what is left of the friction on the slipperiest floor


def docked() -> Pose:
    """Return the pose of a robot that stands in the dock (m, m, rad)."""
    x, y, heading = DOCK
    return x + cos(heading) * DOCKED_M, y + sin(heading) * DOCKED_M, heading + pi


class Plant:
    """MuJoCo with motors that follow a speed within their torque; one `step` is 20 ms."""

    def __init__(self, pose: Pose, with_maze: bool = True, seed: int = 1) -> None:
        self._model = scene.spec(with_maze).compile()
        self._data = mujoco.MjData(self._model)
        self._joints = np.array([self._model.joint(name).qposadr[0] for name in scene.WHEELS])
        self._dofs = np.array([self._model.joint(name).dofadr[0] for name in scene.WHEELS])
        self._rims = [self._model.geom(f"{name}_rim").id for name in scene.WHEELS]
        description = load("irat")
        self._radius = float(description["body"]["wheel_radius"])
        self._range = description["range"]
        self._dice = np.random.default_rng(seed)
        self._groups = np.zeros(6, np.uint8)
        self._groups[scene.FIXED] = 1
        self._hit, self._idle = np.zeros(1, np.int32), 0
        self.dead = 0  # range sensors without power, a bit each: left, ahead, right
        self.put(*pose)

    def put(self, x: float, y: float, heading: float) -> None:
        """Set the robot down elsewhere (m, m, rad); its wheels keep their angles."""
        angles = self._data.qpos[self._joints].copy()
        self._data.qpos[:7] = x, y, 0.0, cos(heading / 2), 0, 0, sin(heading / 2)
        self._data.qpos[self._joints] = angles
        self._data.qvel[:] = 0
        self._idle = 0
        mujoco.mj_forward(self._model, self._data)

    def grip(self, lost: float) -> None:
        """Let the floor lose a share of its friction, 0 to 1."""
        share = 1.0 - (1.0 - LEAST_GRIP) * min(1.0, max(0.0, lost))
        for rim in self._rims:
            self._model.geom_friction[rim, 0] = scene.GRIP[0] * share
        board = self._model.geom("board").id  # of two touching surfaces the rougher counts
        self._model.geom_friction[board, 0] = scene.GRIP[0] * share

    def block(self, blocked: bool) -> None:
        """Hold both wheels fast, or let them go."""
        self._model.dof_damping[self._dofs] = HELD if blocked else FREE

    def step(self, left: float, right: float) -> None:
        """Let 20 ms pass with the motors told these rim speeds (m/s). A body at rest costs nothing."""
        if left == 0.0 and right == 0.0 and self._idle >= 10:
            return
        self._data.ctrl[:] = left / self._radius, right / self._radius
        mujoco.mj_step(self._model, self._data, STEPS)
        self._idle = self._idle + 1 if left == right == 0.0 and self.still else 0

    @property
    def wheels_still(self) -> bool:
        """Return whether the wheels rest; this is all that the robot itself can know."""
        return bool(np.abs(self._data.qvel[self._dofs]).max() < STILL_RAD_S)

    @property
    def still(self) -> bool:
        """Return whether neither wheels nor hull move."""
        return self.wheels_still and bool(np.abs(self._data.qvel[:2]).max() < STILL_M_S)

    @property
    def rims(self) -> tuple[float, float]:
        """Return the measured rim speeds, left and right (m/s)."""
        left, right = self._data.qvel[self._dofs] * self._radius
        return float(left), float(right)

    @property
    def angles(self) -> Floats:
        """Return the angles that the wheels have turned (rad)."""
        return np.array(self._data.qpos[self._joints])

    @property
    def pose(self) -> Pose:
        """Return the true pose (m, m, rad); no sensor of the robot knows it."""
        x, y = self._data.qpos[:2]
        w, a, b, c = self._data.qpos[3:7]
        return float(x), float(y), atan2(2 * (w * c + a * b), 1 - 2 * (b * b + c * c))

    @property
    def frame(self) -> Floats:
        """Return the hull's frame (4 x 4), with the little pitch and roll that a camera shows."""
        found = np.eye(4)
        found[:3, :3] = np.array(self._data.body("hull").xmat).reshape(3, 3)
        found[:3, 3] = self._data.body("hull").xpos
        return found

    @property
    def contacts(self) -> tuple[bool, bool]:
        """Return which of the dock's two springs the robot's discs touch."""
        return touching(DOCK, self.pose)

    def ranges(self) -> tuple[float, float, float]:
        """Return what the infrared sensors read, left, ahead and right (m)."""
        x, y, heading = self.pose
        ahead, aside = self._range["from"]
        place = np.array([x + cos(heading) * ahead - sin(heading) * aside,
                          y + sin(heading) * ahead + cos(heading) * aside, SENSOR_Z])  # fmt: skip
        found = []
        for number, angle in enumerate(self._range["angles"]):
            ray = np.array([cos(heading + angle), sin(heading + angle), 0.0])
            distance = mujoco.mj_ray(self._model, self._data, place, ray, self._groups, 1, -1, self._hit)
            seen = distance if distance >= 0 and not self.dead & 1 << number else self._range["far"]
            seen += NOISE_M * self._dice.standard_normal() if seen < self._range["far"] else 0.0
            found.append(float(min(max(seen, self._range["near"]), self._range["far"])))
        return found[0], found[1], found[2]
