"""The rover's body in the hall: takes rim speeds, returns wheels, contacts and, for judges only, its pose."""

from math import atan2, cos, sin

import mujoco
import numpy as np
from numpy.typing import NDArray

from robots.kit.description import load
from robots.kit.drivers.srv1.hall import Hall, hall
from simulators.srv1 import scene

Floats = NDArray[np.float64]
Pose = tuple[float, float, float]
TICK_S = 0.02
STEPS = round(TICK_S / scene.STEP_S)
STILL_RAD_S, STILL_M_S = 0.05, 0.002  # below this wheels and hull rest
FREE, HELD = 0.0, 5.0  # damping of a wheel, free and blocked (N m s/rad)
LEAST_GRIP = 0.002  # what is left of the friction on the slipperiest floor
LEFT, RIGHT = [0, 2], [1, 3]  # of `scene.WHEELS`


class Plant:
    """MuJoCo with motors that follow a speed within their torque; one `step` is 20 ms."""

    def __init__(self, pose: Pose, where: Hall | None = None) -> None:
        self._hall = where or hall()
        self._model = scene.spec(self._hall).compile()
        self._data = mujoco.MjData(self._model)
        joints = [self._model.joint(name) for name in scene.WHEELS]
        self._joints = np.array([joint.qposadr[0] for joint in joints])
        self._dofs = np.array([joint.dofadr[0] for joint in joints])
        self._names = [self._model.geom(number).name for number in range(self._model.ngeom)]
        self._hull = self._model.geom("hull").id
        self._cases = {case.name: int(self._model.body(case.name).mocapid[0]) for case in self._hall.cases}
        self._radius = float(load("srv1")["body"]["wheel_radius"])
        self._groups = np.zeros(6, np.uint8)
        self._groups[scene.FIXED] = 1
        self._hit, self._idle = np.zeros(1, np.int32), 0
        self.put(*pose)

    def put(self, x: float, y: float, heading: float) -> None:
        """Set the rover down elsewhere (m, m, rad); its wheels keep their angles."""
        angles = self._data.qpos[self._joints].copy()
        self._data.qpos[:7] = x, y, 0.0, cos(heading / 2), 0, 0, sin(heading / 2)
        self._data.qpos[self._joints] = angles
        self._data.qvel[:] = 0
        self._wake()

    def move(self, case: str, dx: float, dy: float) -> None:
        """Move a showcase to this distance (m) from where the description has it. Raises KeyError: there is none."""
        number = self._cases[case]
        at = next(c.at for c in self._hall.cases if c.name == case)
        self._data.mocap_pos[number, :2] = at[0] + dx, at[1] + dy
        self._wake()

    def offset(self, case: str) -> tuple[float, float]:
        """Return how far a showcase is from where the description has it (m, m). Raises KeyError: there is none."""
        at = next(c.at for c in self._hall.cases if c.name == case)
        x, y = self._data.mocap_pos[self._cases[case], :2]
        return float(x) - at[0], float(y) - at[1]

    def _wake(self) -> None:
        self._idle = 0
        mujoco.mj_forward(self._model, self._data)

    def grip(self, lost: float) -> None:
        """Let the floor lose a share of its friction, 0 to 1."""
        share = 1.0 - (1.0 - LEAST_GRIP) * min(1.0, max(0.0, lost))
        self._model.pair_friction[:, 0], self._model.pair_friction[:, 1] = scene.ACROSS * share, scene.ALONG * share

    def block(self, blocked: bool) -> None:
        """Hold all wheels fast, or let them go."""
        self._model.dof_damping[self._dofs] = HELD if blocked else FREE
        self._model.actuator_forcerange[:] = np.array([-1.0, 1.0]) * scene.STALL_NM * (0.0 if blocked else 1.0)

    def step(self, left: float, right: float) -> None:
        """Let 20 ms pass with the motors told these rim speeds (m/s). A body at rest costs nothing."""
        if left == 0.0 and right == 0.0 and self._idle >= 10:
            return
        self._data.ctrl[LEFT], self._data.ctrl[RIGHT] = left / self._radius, right / self._radius
        mujoco.mj_step(self._model, self._data, STEPS)
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
        return float(speeds[LEFT].mean()), float(speeds[RIGHT].mean())

    @property
    def angles(self) -> tuple[float, float]:
        """Return the angles that the rear wheels have turned, left and right (rad): they have the encoders."""
        left, right = self._data.qpos[self._joints[2:]]
        return float(left), float(right)

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

    @property
    def contacts(self) -> tuple[str, ...]:
        """Return what the hull touches: names of showcases and exhibits, `wall0` to `wall3` (S, N, W, E)."""
        pairs = [(c.geom1, c.geom2) for c in self._data.contact if self._hull in (c.geom1, c.geom2)]
        return tuple(sorted({self._names[a + b - self._hull] for a, b in pairs}))

    def in_sight(self, origin: tuple[float, float, float], place: tuple[float, float, float]) -> bool:
        """Return whether nothing stands between a point of the rover's frame and a place of the hall (m)."""
        begin = self._place(origin)
        way = np.subtract(place, begin)
        long = float(np.linalg.norm(way))
        away = mujoco.mj_ray(self._model, self._data, begin, way / max(long, 1e-9), self._groups, 1, -1, self._hit)
        return not 0.0 <= away < long

    def _place(self, origin: tuple[float, float, float]) -> Floats:
        """Return a point of the rover's frame in the hall (m)."""
        x, y, heading = self.pose
        ahead, aside, high = origin
        c, s = cos(heading), sin(heading)
        return np.array([x + c * ahead - s * aside, y + s * ahead + c * aside, high])

    def ray(self, origin: tuple[float, float, float], angle: float) -> tuple[float, str]:
        """Return how far a level ray runs (m), and the name of what it meets; infinite and "" where there is nothing.

        `origin` is in the rover's frame (m), `angle` (rad) to the left of its heading.
        """
        place, heading = self._place(origin), self.pose[2]
        direction = np.array([cos(heading + angle), sin(heading + angle), 0.0])
        away = mujoco.mj_ray(self._model, self._data, place, direction, self._groups, 1, -1, self._hit)
        return (float(away), self._names[int(self._hit[0])]) if away >= 0 else (float("inf"), "")
