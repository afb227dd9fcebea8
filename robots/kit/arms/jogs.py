"""Velocities of an arm's held motions, from the shares of full speed that their commands give. Pure."""

from typing import Any

import numpy as np

from robots.kit.arms.chain import Chain, Joints
from robots.kit.arms.commands import PLACE
from robots.kit.contract.values import number

JOG_SHARE = 0.3  # of full speed, so that the arm rests soon after the keep-alives end
JOG_M_S, JOG_RAD_S = 0.15, 0.6  # of the tool


def joint_velocity(chain: Chain, args: dict[str, Any]) -> Joints:
    """Return the velocity of each joint (rad/s) for `jog_joints`. Raises BadRequest."""
    share = np.array([number({name: 0.0} | args, name) for name in chain.names])
    return share * chain.velocity * JOG_SHARE


def tool_velocity(args: dict[str, Any]) -> Joints:
    """Return the velocity of the tool (m/s along, rad/s about x y z) for `jog_tool`. Raises BadRequest."""
    share = np.array([number({name: 0.0} | args, name) for name in PLACE])
    return np.append(share[:3] * JOG_M_S, share[3:] * JOG_RAD_S)
