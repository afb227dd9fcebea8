"""What is a little different in the cell from what the driver believes, of a seed: only pictures tell."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from robots.kit.files import replace_text
from simulators.puma.cell import Floats, bricks

ZERO_DEG, TOOL_M, PLACE_M, TURN_DEG = 0.03, 0.0003, 0.001, 1.0  # standard deviations
MOST = 2.5  # of a standard deviation
SEEDS = 1 << 32


@dataclass(frozen=True, eq=False)
class Errors:
    """Zeros of the joints (rad: true minus measured), of the tool's place (m), of bricks (m, m, rad) by name."""

    zeros: Floats = field(default_factory=lambda: np.zeros(6))
    tool: Floats = field(default_factory=lambda: np.zeros(3))
    places: dict[str, tuple[float, float, float]] = field(default_factory=dict)


NONE = Errors()


def errors_of(seed: int) -> Errors:
    """Return the errors of a seed, the same each time."""
    dice = np.random.default_rng(seed)

    def some(count: int) -> Floats:
        return np.clip(dice.normal(size=count), -MOST, MOST)

    zeros, tool = np.radians(ZERO_DEG) * some(6), TOOL_M * some(3)
    places = {}
    for name in bricks():
        x, y, turn = some(3)
        places[name] = (PLACE_M * float(x), PLACE_M * float(y), float(np.radians(TURN_DEG) * turn))
    return Errors(zeros, tool, places)


def kept_seed(folder: Path, seed: int | None = None) -> int:
    """Return the seed kept in the simulator's folder; a new one, or the given one, is kept from now on."""
    file = folder / "seed"
    if seed is None:
        try:
            found = int(file.read_text()[:12])
            if 0 <= found < SEEDS:
                return found
        except (OSError, ValueError):
            pass  # none yet, or not readable: the cell is set up anew
        seed = int(np.random.default_rng().integers(SEEDS))
    replace_text(file, f"{seed}\n")
    return seed
