"""The museum arm's control layers: computed torque, and PD without gravity compensation (Craig 1986, chapters 9, 10).

A controller is an object with one method, `torques`.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from robots.kit.arms.chain import Joints
from simulators.common.arm.controllers import ComputedTorque, Controller
from simulators.common.arm.plant import Measured


class ProportionalDerivative:
    """tau = Kp e + Kd e': without a model of the arm, so it sags under gravity and lags behind."""

    def __init__(self, share: float = 1.0) -> None:
        self._kp = share * np.array([9000.0, 9000.0, 5000.0, 900.0, 900.0, 400.0])
        self._kd = share * np.array([500.0, 500.0, 260.0, 40.0, 40.0, 20.0])

    def torques(self, q: Joints, v: Joints, a: Joints, now: Measured) -> Joints:
        """See Controller."""
        return self._kp * (q - now.q) + self._kd * (v - now.v)


CONTROLLERS: dict[str, Callable[[], Controller]] = {
    "computed_torque": partial(ComputedTorque, "pa10"),
    "pd": ProportionalDerivative,
}
