"""The position of a whole scene in a file, from which the simulator starts again."""

from pathlib import Path

import numpy as np

from robots.kit.arms.chain import Joints
from robots.kit.files import replaced


def restore_scene(path: Path) -> Joints | None:
    """Return what is stored there; None if that is nothing, or cannot be."""
    try:
        found = np.load(path, allow_pickle=False)
    except (OSError, ValueError, EOFError):
        return None
    return found if found.dtype == np.float64 and np.isfinite(found).all() else None


def keep_scene(path: Path, qpos: Joints) -> None:
    """Store it. Raises OSError; the old file stays then."""
    with replaced(path) as file:
        np.save(file, qpos)
