"""Control layers, which can be replaced: joint torques from a reference and measured values.

A controller is an object with one method, `torques`. There are two: computed torque (the arm's own dynamics are
compensated, which leaves a double integrator) and PD without gravity compensation (Craig 1986, chapters 9 and 10).
"""

from typing import Protocol

import mujoco
import numpy as np

from robots.kit.arms.chain import Joints
from robots.kit.arms.described import chain
from simulators.pa10 import scene
from simulators.pa10.plant import Measured


class Controller(Protocol):
    """The interface: called at 500 Hz, returns N m for each axis."""

    def torques(self, q: Joints, v: Joints, a: Joints, now: Measured) -> Joints:
        """Return torques that move the arm along the reference (rad, rad/s, rad/s2)."""


class ComputedTorque:
    """tau = M(q) (a + Kv e' + Kp e) + C(q, q') + G(q), from the description's masses."""

    def __init__(self, frequency: float = 12.0) -> None:
        self._model = scene.arm().compile()
        # contacts are not part of the arm's own dynamics
        self._model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        self._data = mujoco.MjData(self._model)
        at, dof = scene.places(self._model, chain("pa10").names)
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


class ProportionalDerivative:
    """tau = Kp e + Kd e': without a model of the arm, so it sags under gravity and lags behind."""

    def __init__(self, share: float = 1.0) -> None:
        self._kp = share * np.array([9000.0, 9000.0, 5000.0, 900.0, 900.0, 400.0])
        self._kd = share * np.array([500.0, 500.0, 260.0, 40.0, 40.0, 20.0])

    def torques(self, q: Joints, v: Joints, a: Joints, now: Measured) -> Joints:
        """See Controller."""
        return self._kp * (q - now.q) + self._kd * (v - now.v)


CONTROLLERS: dict[str, type[Controller]] = {"computed_torque": ComputedTorque, "pd": ProportionalDerivative}
