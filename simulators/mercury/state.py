"""The simulator's state after a kill: the arm's position, and how often it was switched on.

The file is written beside and then replaced, so that readers always see a complete one.
"""

import json
import time
from dataclasses import dataclass
from pathlib import Path

from robots.files import replaced
from simulators.mercury.arm import Pose

START = Pose(0.0, 0.42, 0.075, 0.0)
BOOTS = 2**32


@dataclass(frozen=True)
class Kept:
    """The pose (m, rad) and the last boot number."""

    pose: Pose
    boot: int


def restore(path: Path) -> Kept:
    """Return the state stored in `path`.

    If nothing can be read, the boot number continues from the time of day in seconds, because no number may come twice.
    """
    try:
        kept = json.loads(path.read_text())
        x, y, z, theta = map(float, kept["pose"])
        return Kept(Pose(x, y, z, theta), int(kept["boot"]) % BOOTS)
    except FileNotFoundError:
        return Kept(START, 0)
    except (OSError, ValueError, TypeError, KeyError, OverflowError):
        return Kept(START, int(time.time()) % BOOTS)


def keep(path: Path, pose: Pose, boot: int) -> None:
    """Write the state."""
    with replaced(path) as file:
        file.write(json.dumps({"pose": pose.as_tuple(), "boot": boot}).encode())
