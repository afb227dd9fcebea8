"""An arm itself: takes joint torques, returns positions, velocities and applied torques."""

from dataclasses import dataclass

import mujoco
import numpy as np

from robots.kit.arms.chain import Joints
from robots.kit.arms.described import chain
from robots.kit.description import load
from simulators.common.arm.scene import FINGERS, PRESSING_M, STEP_S, places


@dataclass(frozen=True)
class Measured:
    """The arm's values: rad, rad/s, N m as applied, each finger's opening in m."""

    q: Joints
    v: Joints
    torque: Joints
    opening: float


class Plant:
    """The scene `spec` around the arm of `driver` with torque-driven axes and a gripper; `step` is 2 ms.

    It begins at `qpos`, the position of a whole scene, if its length fits, otherwise with the arm at `q` (rad). With
    `travel_s` in the table `gripper` the fingers take that time from open to closed.
    """

    def __init__(self, driver: str, spec: mujoco.MjSpec, q: Joints | None = None, qpos: Joints | None = None) -> None:
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        arm = chain(driver)
        at, dof = places(self.model, arm.names)
        fingers, _ = places(self.model, FINGERS)
        self._effort = arm.effort
        gripper = load(driver)["gripper"]
        self._open = float(gripper["open"])
        seconds = gripper.get("travel_s")
        self._way = self._open / seconds * STEP_S if seconds else np.inf  # m that a finger moves in a step
        # MuJoCo's own memory, looked up once: each look costs as much as a sum
        self._q, self._fingers = self.data.qpos[at], self.data.qpos[fingers]
        self._v, self._applied, self._ctrl = self.data.qvel[dof], self.data.qfrc_applied[dof], self.data.ctrl
        if qpos is not None and qpos.shape == self.data.qpos.shape:
            self.data.qpos[:] = qpos
        else:
            self._fingers[:] = self._open
            self._q[:] = 0.0 if q is None else q
        self._target = max(PRESSING_M, min(self._fingers.tolist()))  # where the fingers are to be now
        self._torque = np.zeros(len(arm.names))
        self.disturbance = np.zeros(len(arm.names))  # N m of disturbance
        mujoco.mj_forward(self.model, self.data)

    def measured(self) -> Measured:
        """Return positions, velocities, applied torques."""
        left, right = self._fingers.tolist()
        opening = max(0.0, (left + right) / 2)  # pads that press give way a little
        return Measured(self._q.copy(), self._v.copy(), self._torque, opening)

    def step(self, torque: Joints, gripper: int) -> None:
        """Apply torques (N m, limited to the motors') for 2 ms; `gripper` 0 opens, 1 closes."""
        self._torque = np.minimum(np.maximum(torque, -self._effort), self._effort)
        np.add(self._torque, self.disturbance, out=self._applied)
        end = PRESSING_M if gripper else self._open
        self._target += min(max(end - self._target, -self._way), self._way)
        self._ctrl[:] = self._target
        mujoco.mj_step(self.model, self.data)

    @property
    def qpos(self) -> Joints:
        """Return the whole scene's position, for cameras and for the next start."""
        return np.array(self.data.qpos)

    def put_back(self, body: str) -> None:
        """Put an object back at rest where it was at the start."""
        joint = self.model.joint(f"{body}_free")
        at, dof = int(joint.qposadr[0]), int(joint.dofadr[0])
        self.data.qpos[at : at + 7] = self.model.qpos0[at : at + 7]
        self.data.qvel[dof : dof + 6] = 0.0

    def place(self, body: str) -> Joints:
        """Return the position of an object (m)."""
        return np.array(self.data.body(body).xpos)
