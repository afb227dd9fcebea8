"""What outlives a kill: where the robot stands, its charge, and how often it was switched on."""

import json
import time
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

from robots.files import replaced
from simulators.irat.plant import Pose, docked

BOOTS = 2**32


@dataclass(frozen=True)
class Kept:
    """The pose (m, m, rad), the share of the charge, and the last boot number."""

    pose: Pose
    charge: float
    boot: int


def restore(path: Path) -> Kept:
    """Return the state stored in `path`; a new robot stands in its dock, charged.

    If nothing can be read, the boot number continues from the time of day in seconds, because no number may come twice.
    """
    try:
        kept = json.loads(path.read_text())
        x, y, heading = map(float, kept["pose"])
        charge = float(kept["charge"])
        if not all(map(isfinite, (x, y, heading, charge))):
            raise ValueError(kept)
        return Kept((x, y, heading), min(1.0, max(0.0, charge)), int(kept["boot"]) % BOOTS)
    except FileNotFoundError:
        return Kept(docked(), 1.0, 0)
    except (OSError, ValueError, TypeError, KeyError, OverflowError):
        return Kept(docked(), 1.0, int(time.time()) % BOOTS)


def keep(path: Path, kept: Kept) -> None:
    """Write the state."""
    with replaced(path) as file:
        file.write(json.dumps({"pose": kept.pose, "charge": kept.charge, "boot": kept.boot}).encode())
