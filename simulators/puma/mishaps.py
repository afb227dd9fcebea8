"""What happens in the cell by itself, as the fault board says.

`intrude`: a mug stands in the cell while it is set. `vanish`: brick number n, from 1, is away while it is set.
`nudge`: the first brick is pushed by so many mm along y, once. `gust`: wind of so many m/s blows on the rod, every
other 1.3 s, while it is set.
"""

import numpy as np

from simulators.common.faults import FaultBoard
from simulators.puma.cell import Floats, bricks
from simulators.puma.plant import Plant
from simulators.puma.scene import MUG, MUG_M, MUG_PLACE, STORE_M

VERBS = ("intrude", "vanish", "nudge", "gust")
LARGEST_NUDGE_MM, STRONGEST_M_S = 100.0, 12.0
GUST_STEPS = 650  # half the time of a swing
APART_M = 0.3  # between two things in the store
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


class Mishaps:
    """Applies the fault board to a plant; call `step` before each step of the plant."""

    def __init__(self, board: FaultBoard, plant: Plant) -> None:
        self._board, self._plant, self._steps = board, plant, 0
        self._mug = float(plant.place(MUG)[0]) > STORE_M[0] + APART_M  # it may be in the cell from before a restart
        self._away: tuple[str, Floats, Floats] | None = None  # the brick that is away, and where it was

    @property
    def busy(self) -> bool:
        """Return whether something happens now, so that the plant must not rest."""
        mug, gone = bool(self._board.value("intrude")), self._gone()
        here = self._away[0] if self._away else None
        return bool(self._board.value("nudge") or self._board.value("gust")) or mug != self._mug or gone != here

    def _gone(self) -> str | None:
        number = self._board.value("vanish")
        return bricks()[int(number) - 1] if 1 <= number < len(bricks()) + 1 else None

    def step(self) -> None:
        """Do what is set now, end what no longer is."""
        if bool(self._board.value("intrude")) != self._mug:
            self._mug = not self._mug
            place = (*MUG_PLACE, MUG_M[1]) if self._mug else np.add(STORE_M, (0.0, 0.0, MUG_M[1]))
            self._plant.put(MUG, np.array(place), UPRIGHT)
        gone = self._gone()
        if gone != (self._away[0] if self._away else None):
            self._vanish(gone)
        if push := self._board.once("nudge"):
            along = min(max(push, -LARGEST_NUDGE_MM), LARGEST_NUDGE_MM) / 1000
            self._plant.push(bricks()[0], along)
        wind = min(max(self._board.value("gust"), -STRONGEST_M_S), STRONGEST_M_S)
        self._steps = self._steps + 1 if wind else 0
        self._plant.wind = wind if self._steps % (2 * GUST_STEPS) < GUST_STEPS else 0.0

    def _vanish(self, name: str | None) -> None:
        """Bring the brick that is away back to where it was, and take the named one away."""
        if self._away is not None:
            self._plant.put(*self._away)
            self._away = None
        if name is not None:
            self._away = (name, *self._plant.lies(name))
            store = np.add(STORE_M, (0.0, APART_M * (1 + bricks().index(name)), 0.0096))
            self._plant.put(name, store, UPRIGHT)
