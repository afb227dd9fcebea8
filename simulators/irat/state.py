"""The state that outlives a kill: the pose of the robot, its charge, and how often it was switched on."""

from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

from simulators.common import nonvolatile as kept
from simulators.irat.plant import Pose, docked


@dataclass(frozen=True)
class StoredState:
    """The pose (m, m, rad), the share of the charge, and the last boot number."""

    pose: Pose
    charge: float
    boot: int


def _body(stored: Any) -> tuple[Pose, float]:
    x, y, heading = map(float, stored["pose"])
    charge = float(stored["charge"])
    if not all(map(isfinite, (x, y, heading, charge))):
        raise ValueError(stored)
    return (x, y, heading), min(1.0, max(0.0, charge))


def restore(path: Path) -> StoredState:
    """Return the state stored in `path`; a new robot stands in its dock, charged."""
    (pose, charge), boot = kept.restored(path, _body, (docked(), 1.0))
    return StoredState(pose, charge, boot)


def keep(path: Path, state: StoredState) -> None:
    """Write the state. Raises OSError."""
    kept.keep(path, state.boot, {"pose": state.pose, "charge": state.charge})
