"""The simulator's state after a kill: the arm's position, and how often it was switched on."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from simulators.common import nonvolatile as kept
from simulators.mercury.arm import Pose

START = Pose(0.0, 0.42, 0.075, 0.0)


@dataclass(frozen=True)
class StoredState:
    """The pose (m, rad) and the last boot number."""

    pose: Pose
    boot: int


def _pose(stored: Any) -> Pose:
    x, y, z, theta = map(float, stored["pose"])
    return Pose(x, y, z, theta)


def restore(path: Path) -> StoredState:
    """Return the state stored in `path`; a new arm stands at its start."""
    return StoredState(*kept.restore(path, _pose, START))


def keep(path: Path, pose: Pose, boot: int) -> None:
    """Write the state. Raises OSError."""
    kept.keep(path, boot, {"pose": pose.as_tuple()})
