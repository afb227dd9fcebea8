"""The arm in its cell: takes joint torques, returns what its encoders tell; and what else happens in the cell."""

from dataclasses import replace

import mujoco
import numpy as np

from robots.kit.arms.chain import Joints
from simulators.common.arm import plant
from simulators.common.arm.plant import Measured
from simulators.common.arm.scene import STEP_S
from simulators.puma import rod, scene
from simulators.puma.cell import DRIVER, Floats, things
from simulators.puma.clutch import Clutch
from simulators.puma.errors import NONE, Errors

PUSH_S, FASTEST_M_S = 0.2, 0.6  # of a push
ABOVE_M = 0.002  # between a thing that is put back and what lies at its place
NEAR_M = 0.08  # two middles nearer than this may overlap


class Plant(plant.Plant):
    """MuJoCo with torque-driven axes, clutching bricks and the rod; one call of `step` is 2 ms.

    `q` is the arm's posture as its encoders measure it (rad), `qpos` the whole scene's true position.
    """

    def __init__(self, q: Joints | None = None, qpos: Joints | None = None, errors: Errors = NONE) -> None:
        start = errors.zeros if q is None else q + errors.zeros
        super().__init__(DRIVER, scene.spec(errors), start, qpos)
        self._zeros = errors.zeros
        rod.damp(self.model)
        mujoco.mj_forward(self.model, self.data)
        self.clutch = Clutch(self.model, self.data)
        self.wind = 0.0  # m/s along y, on the rod
        self._rod, self._thing = self.model.body(rod.ROD).id, things()[rod.ROD]
        self._pushes: dict[str, tuple[float, int]] = {}  # y of its end (m), steps that are left

    def measured(self) -> Measured:
        """Return positions as the encoders tell them, velocities, applied torques."""
        true = super().measured()
        return replace(true, q=true.q - self._zeros)

    def step(self, torque: Joints, gripper: int) -> None:
        """Apply torques (N m, limited to the motors') for 2 ms; `gripper` 0 opens, 1 closes."""
        if self.wind or self.data.xfrc_applied[self._rod, 1]:
            self._blow()
        if self._pushes:
            self._push()
        super().step(torque, gripper)
        self.clutch.step()

    def pose(self, body: str) -> Floats:
        """Return the pose of a body (4 x 4)."""
        found, at = np.eye(4), self.data.body(body)
        found[:3, :3], found[:3, 3] = at.xmat.reshape(3, 3), at.xpos
        return found

    def push(self, body: str, along: float) -> None:
        """Push an object along y by so much (m), as a finger does that touches it; what holds it is stronger."""
        self._pushes[body] = float(self.place(body)[1]) + along, round(PUSH_S / STEP_S)

    def put(self, body: str, place: Floats, quaternion: Floats) -> None:
        """Put an object at a place (m), at rest and held by nothing; above what lies there already."""
        at, dof = self._free(body)
        place = np.array(place, float)
        while self._occupied(body, place):
            place[2] += ABOVE_M
        self.clutch.let_go(body)
        self.data.qpos[at : at + 7] = [*place, *quaternion]
        self.data.qvel[dof : dof + 6] = 0.0
        self._pushes.pop(body, None)
        mujoco.mj_forward(self.model, self.data)

    def put_back(self, body: str) -> None:
        """Put an object back at rest where it was at the start."""
        at, _ = self._free(body)
        first = self.model.qpos0[at : at + 7]
        self.put(body, first[:3], first[3:])

    def lies(self, body: str) -> tuple[Floats, Floats]:
        """Return place (m) and quaternion of an object."""
        at, _ = self._free(body)
        here = np.array(self.data.qpos[at : at + 7])
        return here[:3], here[3:]

    def _free(self, body: str) -> tuple[int, int]:
        joint = self.model.joint(f"{body}_free")
        return int(joint.qposadr[0]), int(joint.dofadr[0])

    def _occupied(self, body: str, place: Floats) -> bool:
        others = (*things(), scene.MUG)
        return any(np.linalg.norm(self.place(name) - place) < NEAR_M for name in others if name not in (body, rod.ROD))

    def _blow(self) -> None:
        _, dof = self._free(rod.ROD)
        velocity = self.data.qvel[dof : dof + 3]
        self.data.xfrc_applied[self._rod, :3] = rod.wind(velocity, self.wind, self._thing) if self.wind else 0.0

    def _push(self) -> None:
        for body, (end, left) in list(self._pushes.items()):
            _, dof = self._free(body)
            speed = (end - float(self.place(body)[1])) / (left * STEP_S) if left else 0.0
            self.data.qvel[dof + 1] = min(max(speed, -FASTEST_M_S), FASTEST_M_S)
            if left:
                self._pushes[body] = end, left - 1
            else:
                del self._pushes[body]
