"""Puts objects back that lie beside the table, as staff would."""

from collections.abc import Iterable

from simulators.common.arm.plant import Plant
from simulators.common.journal import Note

LOOK_EVERY = 500  # steps between two looks
FALLEN_M, LOOKS = -0.1, 3  # lower than this in so many looks, an object has fallen


class Fallen:
    """The objects that lie beside the table now."""

    def __init__(self, plant: Plant, note: Note) -> None:
        self._plant, self._note = plant, note
        self._looks: dict[str, int] = {}

    def any(self) -> bool:
        """Return whether there are some."""
        return any(self._looks.values())

    def look(self, objects: Iterable[str]) -> None:
        """Look for each of these objects; put back those that have lain there for a while."""
        for name in objects:
            away = self._plant.place(name)[2] < FALLEN_M
            self._looks[name] = self._looks.get(name, 0) + 1 if away else 0
            if self._looks[name] > LOOKS:
                self._plant.put_back(name)
                self._note("put_back", what=name)
