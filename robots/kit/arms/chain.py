"""A serial arm from its URDF: joints with their limits, and the poses of its links.

Independent of any robot. Lengths in m, angles in rad; poses are 4 x 4 homogeneous matrices in the frame of the base.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import degrees
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Matrix = NDArray[np.float64]
Joints = NDArray[np.float64]


@dataclass(frozen=True)
class Joint:
    """One revolute joint: the fixed transform before it, its axis there, its limits.

    `low`, `high` (rad) are the narrower of the mechanical and the soft limits; `velocity`
    in rad/s, `effort` in N m.
    """

    name: str
    origin: Matrix
    axis: Matrix
    low: float
    high: float
    velocity: float
    effort: float


def _transform(element: ElementTree.Element | None) -> Matrix:
    made = np.eye(4)
    if element is not None:
        made[:3, 3] = _numbers(element.get("xyz", "0 0 0"))
        made[:3, :3] = Rotation.from_euler("xyz", _numbers(element.get("rpy", "0 0 0"))).as_matrix()
    return made


def _numbers(text: str) -> list[float]:
    return [float(part) for part in text.split()]


def _number(element: ElementTree.Element | None, name: str, otherwise: float) -> float:
    return otherwise if element is None else float(element.get(name, otherwise))


@dataclass(frozen=True)
class Chain:
    """The revolute joints from the base to one link, and the transform from the last joint to it."""

    joints: tuple[Joint, ...]
    tool: Matrix

    @classmethod
    def from_urdf(cls, text: str, tip: str) -> "Chain":
        """Read the chain that ends in the link `tip`.

        Raises:
            ValueError: no such link, or a joint in the chain that is neither fixed nor revolute.

        """
        root = ElementTree.fromstring(text)  # noqa: S314 - our own file, never somebody's upload
        above = {_link(joint, "child"): joint for joint in root.findall("joint")}
        if tip not in above:
            raise ValueError(f"the description has no link {tip!r} with a joint above it")
        branch, link = [], tip
        while link in above:
            branch.append(above[link])
            link = _link(above[link], "parent")
        joints: list[Joint] = []
        here = np.eye(4)
        for element in reversed(branch):
            here = here @ _transform(element.find("origin"))
            kind = element.get("type")
            if kind == "revolute":
                joints.append(_joint(element, here))
                here = np.eye(4)
            elif kind != "fixed":
                raise ValueError(f"joint {element.get('name')} of type {kind} cannot be in the chain")
        return cls(tuple(joints), here)

    def joints_in(self, values: Sequence[float]) -> Joints:
        """Return this chain's joints (rad) of a state's, which may end with those of a gripper."""
        return np.array(values[: len(self.joints)])

    @property
    def names(self) -> tuple[str, ...]:
        """Return the joints' names from the base on."""
        return tuple(j.name for j in self.joints)

    @cached_property
    def low(self) -> Joints:
        """Return the lower limits (rad)."""
        return np.array([j.low for j in self.joints])

    @cached_property
    def high(self) -> Joints:
        """Return the upper limits (rad)."""
        return np.array([j.high for j in self.joints])

    @cached_property
    def velocity(self) -> Joints:
        """Return the greatest speeds (rad/s)."""
        return np.array([j.velocity for j in self.joints])

    @cached_property
    def effort(self) -> Joints:
        """Return the greatest torques (N m)."""
        return np.array([j.effort for j in self.joints])

    @cached_property
    def _steps(self) -> tuple[Matrix, Matrix, Matrix]:
        """Return three (n, 4, 4): a joint's transform is the first + cos q times the second + sin q times the third."""
        origins, parts = np.array([j.origin for j in self.joints]), np.zeros((3, len(self.joints), 4, 4))
        for n, (x, y, z) in enumerate(self._axes):  # Rodrigues
            along = np.outer((x, y, z), (x, y, z))
            across = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
            parts[:, n, :3, :3] = along, np.eye(3) - along, across
        parts[0, :, 3, 3] = 1.0
        still, level, quarter = origins @ parts
        return still, level, quarter

    def frames(self, q: Joints) -> Matrix:
        """Return the (..., n + 1, 4, 4) poses of each joint's frame, turned, and of the tool; `q` is (..., n)."""
        angle = np.asarray(q, dtype=np.float64)[..., None, None]
        still, level, quarter = self._steps
        steps = still + np.cos(angle) * level + np.sin(angle) * quarter
        found = np.empty((*angle.shape[:-3], len(self.joints) + 1, 4, 4))
        here = found[..., 0, :, :] = steps[..., 0, :, :]
        for i in range(1, len(self.joints)):
            here = found[..., i, :, :] = here @ steps[..., i, :, :]
        found[..., -1, :, :] = here @ self.tool
        return found

    def forward(self, q: Joints) -> Matrix:
        """Return the pose of the tool, (..., 4, 4) for `q` of shape (..., n)."""
        pose: Matrix = self.frames(q)[..., -1, :, :]
        return pose

    def jacobian(self, q: Joints) -> Matrix:
        """Return the (..., 6, n) Jacobian of the tool: linear rows first, in the base's frame; `q` is (..., n)."""
        frames = self.frames(q)
        axes = np.einsum("...nij,nj->...ni", frames[..., :-1, :3, :3], self._axes)
        arms = frames[..., -1:, :3, 3] - frames[..., :-1, :3, 3]
        ahead, behind = [1, 2, 0], [2, 0, 1]
        across = axes[..., ahead] * arms[..., behind] - axes[..., behind] * arms[..., ahead]
        return np.concatenate([across, axes], axis=-1).swapaxes(-1, -2)

    @cached_property
    def _axes(self) -> Matrix:
        return np.array([j.axis for j in self.joints])

    def broken_limit(self, q: Joints, slack: float = 1e-9) -> str:
        """Return a sentence that names the first joint outside its limits; empty if all are inside."""
        for joint, value in zip(self.joints, np.asarray(q, float), strict=True):
            if not joint.low - slack <= value <= joint.high + slack:
                low, high, at = (degrees(float(v)) for v in (joint.low, joint.high, value))
                there = f"{at:.1f}" if abs(at) < 1e6 else f"{at:.3g}"
                return f"joint {joint.name} would be at {there}°, outside {low:.1f}° to {high:.1f}°"
        return ""


def _link(joint: ElementTree.Element, which: str) -> str:
    element = joint.find(which)
    return "" if element is None else element.get("link", "")


def _joint(element: ElementTree.Element, origin: Matrix) -> Joint:
    limit, soft, axis = element.find("limit"), element.find("safety_controller"), element.find("axis")
    low, high = _number(limit, "lower", -np.pi), _number(limit, "upper", np.pi)
    direction = np.array(_numbers(axis.get("xyz", "1 0 0") if axis is not None else "1 0 0"))
    return Joint(
        name=element.get("name", ""),
        origin=origin,
        axis=direction / np.linalg.norm(direction),
        low=max(low, _number(soft, "soft_lower_limit", low)),
        high=min(high, _number(soft, "soft_upper_limit", high)),
        velocity=_number(limit, "velocity", 1.0),
        effort=_number(limit, "effort", 0.0),
    )
