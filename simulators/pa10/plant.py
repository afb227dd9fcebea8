"""The museum arm itself, among its blocks.

This is the open controller architecture of the PA10 (Dziemian et al. 2004, "Introduction"): another control layer
replaces `simulators.pa10.controllers`, not this file.
"""

from robots.kit.arms.chain import Joints
from simulators.common.arm import plant
from simulators.pa10 import scene


class Plant(plant.Plant):
    """The arm with torque-driven axes; see there."""

    def __init__(self, q: Joints | None = None, qpos: Joints | None = None) -> None:
        super().__init__("pa10", scene.spec(), q, qpos)
