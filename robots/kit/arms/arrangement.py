"""Where objects are in a moment, and what may be done with them: pure, and the same for a task that is only tried.

Poses are 4 x 4, in the frame of the base; lengths in m.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import pi, remainder

import numpy as np

from robots.kit.arms.chain import Matrix
from robots.kit.arms.objects import TABLE, DescribedObject, ObjectTable, placed_of, pose_of, yaw_of
from robots.kit.arms.plates import PLATE
from robots.kit.arms.solids import TOUCH_M, Solid, cover, is_over, overlap, rests_on
from robots.kit.contract.objects import Placed

SQUARE = 1e-4  # rad by which a turn onto studs may differ from quarters
REACH_M = 0.012  # an object whose middle is no farther from the tool than a grasp says, within this, is between fingers


class NotPossible(ValueError):
    """What was asked cannot be done with the objects as they are; the message says why, without a full stop."""


@dataclass(frozen=True)
class Arrangement:
    """Where each object is that is known: its place, in the frame of the tool for the one that is held."""

    table: ObjectTable
    places: Mapping[str, Placed] = field(default_factory=dict)

    @property
    def held(self) -> str | None:
        """Return the name of the object in the gripper, or None."""
        return next((name for name, placed in self.places.items() if placed.held), None)

    def load(self) -> tuple[str, Matrix] | None:
        """Return the object in the gripper and its pose in the tool's frame, or None."""
        name = self.held
        return None if name is None else (name, pose_of(self.places[name]))

    def described(self, name: str) -> DescribedObject:
        """Return the object of that name. Raises NotPossible."""
        found = self.table.named(name)
        if found is None:
            written = ", ".join(self.table.objects)  # as tasks name them, in all languages
            raise NotPossible(f"there is no object {name}; there are {written}")
        return found

    def pose(self, name: str) -> Matrix:
        """Return where an object is that is not held. Raises NotPossible."""
        self.described(name)
        placed = self.places.get(name)
        if placed is None:
            raise NotPossible(f"where {name} lies is not known")
        if placed.held:
            raise NotPossible(f"{name} is in the gripper")
        return pose_of(placed)

    def solid(self, name: str) -> Solid:
        """Return the box around an object that is not held. Raises NotPossible."""
        return self.described(name).solid(self.pose(name))

    def bearing(self, name: str) -> tuple[Matrix, float]:
        """Return the pose (4 x 4) of an object or of the plate, and how high its top is. Raises NotPossible."""
        if name == PLATE:
            if self.table.plate is None:
                raise NotPossible("there is no plate")
            return self.table.plate.pose, self.table.plate.top
        return self.pose(name), self.solid(name).top

    def on_top(
        self, name: str, rotation: Matrix, on: str, by: tuple[float, float], stud: tuple[int, int] | None = None
    ) -> Matrix:
        """Return the pose (4 x 4) of an object, so turned (3 x 3), on another one or on the plate.

        It is moved in the frame of that one (m), or covers a stud of the plate with its corner of lowest column and
        row. Raises NotPossible.
        """
        base, height = self.bearing(on)
        x, y = (base[:3, 3] + base[:3, :3] @ (*by, 0.0))[:2]
        pose = self.described(name).standing(rotation, x, y, height)
        return pose if stud is None else self._on_stud(self.described(name).solid(pose), stud)

    def _on_stud(self, solid: Solid, stud: tuple[int, int]) -> Matrix:
        plate, pose = self.table.plate, solid.pose
        assert plate is not None, "it bears the object"
        if abs(remainder(yaw_of(pose), pi / 2)) > SQUARE:
            raise NotPossible("onto studs it is turned by 0, 90, 180 or 270 degrees")
        pose[:2, 3] = plate.middle(stud, solid)
        if not plate.bears(Solid(pose, solid.half)):
            columns, rows = plate.studs
            raise NotPossible(f"there is no room at {stud[0]} {stud[1]}: the plate has {columns} columns, {rows} rows")
        return pose

    def lying(self, *but: str) -> Iterator[tuple[str, Solid]]:
        """Yield the objects that are known and not held, but some; and the plate, on which they may lie."""
        if self.table.plate is not None:
            yield PLATE, self.table.plate.solid
        for name, placed in self.places.items():
            if not placed.held and name not in but:
                yield name, self.table.objects[name].solid(pose_of(placed))

    def beneath(self, name: str) -> tuple[str, ...]:
        """Return what an object lies on: objects, or the table. Raises NotPossible."""
        solid = self.solid(name)
        lower = tuple(other for other, there in self.lying(name) if rests_on(solid, there))
        return lower or ((TABLE,) if abs(solid.bottom - self.table.height) <= TOUCH_M else ())

    def with_held(self, name: str, tool: Matrix) -> "Arrangement":
        """Return the objects after one was taken where it lies, with the tool at a pose. Raises NotPossible."""
        grip = np.linalg.inv(tool) @ self.pose(name)
        return Arrangement(self.table, {**self.places, name: placed_of(grip, held=True)})

    def with_place(self, name: str, pose: Matrix) -> "Arrangement":
        """Return the objects after one was put at a pose."""
        return Arrangement(self.table, {**self.places, name: placed_of(pose)})

    def without(self, name: str) -> "Arrangement":
        """Return the objects where one is lost: nobody knows where it lies."""
        return Arrangement(self.table, {other: at for other, at in self.places.items() if other != name})

    def released(self, tool: Matrix) -> "Arrangement":
        """Return the objects after the gripper has opened with the tool at a pose; what has nothing beneath is lost."""
        load = self.load()
        if load is None:
            return self
        name, grip = load
        pose = tool @ grip
        try:
            return self.with_place(name, self.settled(name, pose))
        except NotPossible:
            return self.without(name)

    def settled(self, name: str, pose: Matrix) -> Matrix:
        """Return where an object comes to lie that is released at a pose. Raises NotPossible where it would fall."""
        solid = self.described(name).solid(pose)
        falls = 0.0
        if not self.described(name).hangs:
            under = [there.top for _, there in self.lying(name) if cover(solid, there)]
            lower = [top for top in (*under, self.table.height) if top <= solid.bottom + TOUCH_M]
            if not lower or solid.bottom - max(lower) > abs(self.table.release) + 2 * TOUCH_M:
                raise NotPossible(f"{name} would fall")
            falls = solid.bottom - max(lower)
        rested = pose.copy()
        rested[2, 3] -= falls
        return rested

    def between_fingers(self, tool: Matrix) -> str | None:
        """Return the object that a gripper takes that closes with its tool at a pose; None if there is none."""
        here = tool[:3, 3]
        for name, solid in self.lying():
            for grasp in self.described(name).grasps if name != PLATE else ():
                inside = np.linalg.norm(np.linalg.inv(grasp.tool)[:3, 3])
                if np.linalg.norm(solid.pose[:3, 3] - here) <= inside + REACH_M:
                    return name
        return None

    # what may be done

    def check_grasp(self, name: str) -> None:
        """Refuse to take an object that is held, not known, or under another one. Raises NotPossible."""
        if self.held is not None:
            raise NotPossible(f"the gripper holds {self.held} already")
        solid = self.solid(name)
        for other, there in self.lying(name):
            if rests_on(there, solid):
                raise NotPossible(f"{other} lies on {name}")

    def check_fingers(self, tool: Matrix, *but: str) -> None:
        """Refuse a place of the open gripper where it would touch another object. Raises NotPossible."""
        room = self.table.fingers_at(tool)
        for other, there in self.lying(*but):
            if overlap(room, there):
                raise NotPossible(f"the open gripper would touch {other}")

    def check_place(self, name: str, pose: Matrix) -> None:
        """Refuse a place where an object may not lie, would fall, or something else is. Raises NotPossible."""
        described, solid = self.described(name), self.described(name).solid(pose)
        for other, there in self.lying(name):
            if overlap(solid, there):
                raise NotPossible(f"{other} is there")
        x, y = float(pose[0, 3]), float(pose[1, 3])
        lower = [(other, there) for other, there in self.lying(name) if rests_on(solid, there)]
        for other, _ in lower:
            if other == PLATE:
                continue
            carries = self.described(other).carries
            if name not in carries and "*" not in carries:
                raise NotPossible(f"{name} may not be put on {other}")
        if described.hangs or any(is_over(there, x, y) for _, there in lower):
            return
        if lower:
            raise NotPossible(f"{name} would tip: its middle is over nothing")
        if abs(solid.bottom - self.table.height) > TOUCH_M:
            raise NotPossible(f"nothing is beneath {name} there")
        if not self.table.is_free(x, y):
            (x0, y0), (x1, y1) = self.table.area
            raise NotPossible(
                f"{x * 1000:.0f} {y * 1000:.0f} is not on the free part of the table, "
                f"{x0 * 1000:.0f} {y0 * 1000:.0f} to {x1 * 1000:.0f} {y1 * 1000:.0f} mm"
            )
