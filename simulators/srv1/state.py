"""The state that outlives a kill: the pose of the rover, its charge, and how often it was switched on."""

from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

from robots.kit.drivers.srv1.hall import hall
from simulators.common import nonvolatile as kept
from simulators.srv1.flash import SECTOR
from simulators.srv1.plant import Pose


@dataclass(frozen=True)
class StoredState:
    """The pose (m, m, rad), the share of the charge, and the last boot number."""

    pose: Pose
    charge: float
    boot: int


def _body(stored: Any) -> tuple[Pose, float]:
    x, y, heading = map(float, stored["pose"])
    charge = float(stored["charge"])
    where = hall()
    if not (0 <= x <= where.width and 0 <= y <= where.depth and isfinite(heading) and isfinite(charge)):
        raise ValueError(stored)
    return (x, y, heading), min(1.0, max(0.0, charge))


def restore(path: Path) -> StoredState:
    """Return the state stored in `path`; a new rover stands at home, charged."""
    (pose, charge), boot = kept.restored(path, _body, (hall().home, 1.0))
    return StoredState(pose, charge, boot)


def keep(path: Path, state: StoredState) -> None:
    """Write the state. Raises OSError."""
    kept.keep(path, state.boot, {"pose": state.pose, "charge": state.charge})


def restore_flash(path: Path) -> bytes:
    """Return the user's sector of the flash memory that was stored in `path`; nothing if that cannot be read."""
    try:
        return path.read_bytes()[:SECTOR]
    except OSError:
        return b""
