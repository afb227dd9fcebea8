"""The state that outlives a kill of a simulator: one JSON object with the number of its last start.

A complete file replaces the old one, so that readers never see a part of one.
"""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from robots.kit.clock import WALL, Wall
from robots.kit.files import replaced

BOOTS = 2**32
State = TypeVar("State")


def restore(path: Path, read: Callable[[Any], State], new: State, wall: Wall = WALL) -> tuple[State, int]:
    """Return what `read` makes of the stored object, and the last boot number; `new` and 0 if nothing was stored yet.

    If the file cannot be read, return `new`, and a boot number that continues from the time of day in seconds, because
    no number may be used twice. `read` may raise ValueError, TypeError, KeyError and OverflowError.
    """
    try:
        stored = json.loads(path.read_text())
        return read(stored), int(stored["boot"]) % BOOTS
    except FileNotFoundError:
        return new, 0
    except (OSError, ValueError, TypeError, KeyError, OverflowError):
        return new, int(wall()) % BOOTS


def keep(path: Path, boot: int, state: Mapping[str, object]) -> None:
    """Write the object. Raises OSError."""
    with replaced(path) as file:
        file.write(json.dumps({**state, "boot": boot}).encode())
