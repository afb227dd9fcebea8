"""Control layers, which can be replaced: joint torques from a reference and measured values."""

from typing import Protocol

import mujoco
import numpy as np

from robots.kit.arms.chain import Joints
from robots.kit.arms.described import chain
from simulators.common.arm import scene
from simulators.common.arm.plant import Measured


class Controller(Protocol):
    """The interface: called at 500 Hz, returns N m for each axis."""

    def torques(self, q: Joints, v: Joints, a: Joints, now: Measured) -> Joints:
        """Return torques that move the arm along the reference (rad, rad/s, rad/s2)."""


class ComputedTorque:
    """tau = M(q) (a + Kv e' + Kp e) + C(q, q') + G(q), from the description's masses (Craig 1986, chapter 9).

    The arm's own dynamics are compensated, which leaves a double integrator.
    """

    def __init__(self, driver: str, frequency: float = 12.0) -> None:
        self._model = scene.arm(driver).compile()
        # contacts are not part of the arm's own dynamics
        self._model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        self._data = mujoco.MjData(self._model)
        at, dof = scene.places(self._model, chain(driver).names)
        self._q, self._v, self._a = self._data.qpos[at], self._data.qvel[dof], self._data.qacc[dof]
        self._torque = self._data.qfrc_inverse[dof]
        w = 2 * np.pi * frequency / 2
        self._kp, self._kv = w * w, 2 * w

    def torques(self, q: Joints, v: Joints, a: Joints, now: Measured) -> Joints:
        """See Controller."""
        self._q[:], self._v[:] = now.q, now.v
        self._a[:] = a + self._kv * (v - now.v) + self._kp * (q - now.q)
        mujoco.mj_inverse(self._model, self._data)
        torque: Joints = self._torque.copy()
        return torque
