"""The body of a rover in MuJoCo: it takes rim speeds, and returns wheels, rays and, for judges only, its pose."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from math import atan2, cos, inf, sin
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Pose = tuple[float, float, float]
Point = tuple[float, float, float]  # in the rover's frame: ahead, to the left, above the floor (m)
TICK_S = 0.02
STILL_RAD_S, STILL_M_S = 0.05, 0.002  # below this wheels and hull rest
STILL_TICKS = 10  # after so many a body at rest is not computed any more
LEAST_GRIP = 0.002  # what is left of the friction on the slipperiest floor
ROBOT, FIXED = 0, 1  # geometry groups of a scene: the ray of a range sensor looks for the second only


class Body(ABC):
    """Motors that follow a speed within their torque; one `step` is 20 ms.

    `spec` is a scene whose first joint is the free one of the body `hull`. `wheels` are the names of joints, in pairs
    of a left and a right one; the actuators have the same order. `radius` is the wheels' (m).
    """

    FREE, HELD = 0.0, 0.0  # damping of a wheel, free and blocked (N m s/rad)

    def __init__(self, spec: Any, wheels: Sequence[str], radius: float, pose: Pose) -> None:
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        joints = [self._model.joint(name) for name in wheels]
        self._joints = np.array([joint.qposadr[0] for joint in joints])
        self._dofs = np.array([joint.dofadr[0] for joint in joints])
        self._names = [self._model.geom(number).name for number in range(self._model.ngeom)]
        self._radius, self._steps = radius, round(TICK_S / self._model.opt.timestep)
        self._groups = np.zeros(6, np.uint8)
        self._groups[FIXED] = 1
        self._hit, self._idle = np.zeros(1, np.int32), 0
        self.put(*pose)

    def put(self, x: float, y: float, heading: float) -> None:
        """Set the rover down elsewhere (m, m, rad); its wheels keep their angles."""
        angles = self._data.qpos[self._joints].copy()
        self._data.qpos[:7] = x, y, 0.0, cos(heading / 2), 0, 0, sin(heading / 2)
        self._data.qpos[self._joints] = angles
        self._data.qvel[:] = 0
        self._wake()

    def _wake(self) -> None:
        self._idle = 0
        mujoco.mj_forward(self._model, self._data)

    def grip(self, lost: float) -> None:
        """Let the floor lose a share of its friction, 0 to 1."""
        self._set_friction(1.0 - (1.0 - LEAST_GRIP) * min(1.0, max(0.0, lost)))

    @abstractmethod
    def _set_friction(self, share: float) -> None:
        """Give floor and wheels this share of their friction."""

    def block(self, blocked: bool) -> None:
        """Hold all wheels fast, or let them go."""
        self._model.dof_damping[self._dofs] = self.HELD if blocked else self.FREE

    def step(self, left: float, right: float) -> None:
        """Let 20 ms pass with these rim speeds (m/s) for the motors. A body at rest costs nothing."""
        if left == 0.0 and right == 0.0 and self._idle >= STILL_TICKS:
            return
        self._data.ctrl[0::2], self._data.ctrl[1::2] = left / self._radius, right / self._radius
        mujoco.mj_step(self._model, self._data, self._steps)
        self._idle = self._idle + 1 if left == right == 0.0 and self.still else 0

    @property
    def wheels_still(self) -> bool:
        """Return whether the wheels rest; this is all that the rover itself can know."""
        return bool(np.abs(self._data.qvel[self._dofs]).max() < STILL_RAD_S)

    @property
    def still(self) -> bool:
        """Return whether neither wheels nor hull move."""
        return self.wheels_still and bool(np.abs(self._data.qvel[:2]).max() < STILL_M_S)

    @property
    def rims(self) -> tuple[float, float]:
        """Return the measured rim speeds of the two sides, left and right (m/s)."""
        speeds = self._data.qvel[self._dofs] * self._radius
        return float(speeds[0::2].mean()), float(speeds[1::2].mean())

    @property
    def angles(self) -> Floats:
        """Return the angles that the last two wheels, left and right, have turned (rad): they have the encoders."""
        return np.array(self._data.qpos[self._joints[-2:]])

    @property
    def pose(self) -> Pose:
        """Return the true pose (m, m, rad); no sensor of the rover knows it."""
        x, y = self._data.qpos[:2]
        w, a, b, c = self._data.qpos[3:7]
        return float(x), float(y), atan2(2 * (w * c + a * b), 1 - 2 * (b * b + c * c))

    @property
    def frame(self) -> Floats:
        """Return the hull's frame (4 x 4), with the little pitch and roll that a camera shows."""
        frame = np.eye(4)
        frame[:3, :3] = np.array(self._data.body("hull").xmat).reshape(3, 3)
        frame[:3, 3] = self._data.body("hull").xpos
        return frame

    def place(self, point: Point) -> Floats:
        """Return where a point of the rover's frame is in its surroundings (m)."""
        x, y, heading = self.pose
        ahead, aside, high = point
        c, s = cos(heading), sin(heading)
        return np.array([x + c * ahead - s * aside, y + s * ahead + c * aside, high])

    def ray(self, origin: Point, angle: float) -> tuple[float, str]:
        """Return the length of a level ray (m) and the name of what it meets; infinite and "" where it meets nothing.

        `angle` (rad) is counted from the rover's heading to the left.
        """
        direction = self.pose[2] + angle
        length = self._ray(self.place(origin), np.array([cos(direction), sin(direction), 0.0]))
        return (length, self._names[int(self._hit[0])]) if length >= 0 else (inf, "")

    def _ray(self, begin: Floats, direction: Floats) -> float:
        """Return the length of a ray (m), in units of `direction`; negative where it meets nothing."""
        return float(mujoco.mj_ray(self._model, self._data, begin, direction, self._groups, 1, -1, self._hit))
