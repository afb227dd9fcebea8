"""The objects around an arm, as `robot.toml` describes them: the tables `objects` and `object`. Pure.

Lengths in m, angles in degrees as people write them; poses are RPY (`pose.py`). Each object's frame is in its middle.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from math import pi
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from robots.kit.arms.chain import Matrix
from robots.kit.arms.plates import PLATE, Plate, plate_in
from robots.kit.arms.solids import Solid
from robots.kit.arms.tables import BadDescription, Three, number, numbers, pose, table_of, three, whole
from robots.kit.contract.objects import MOST, REACH_M, Box, Placed
from robots.kit.description import load

NAME = re.compile(r"[A-Za-z][A-Za-z0-9-]{0,29}")
TABLE = "table"  # the surface on which objects are put
RESERVED = frozenset({TABLE, PLATE, "on", "at", "by", "turned", "holding", "empty", "tool"})
SHAPES = ("box", "cylinder")
LARGEST_M = 2.0


@dataclass(frozen=True)
class Grasp:
    """A way to take an object: the tool's pose (4 x 4) in the object's frame, and from where it comes and leaves.

    `away` is a way (m) in the object's frame: the tool comes along it on a straight line, and leaves by it after a
    release.
    """

    tool: Matrix
    away: Three


@dataclass(frozen=True, eq=False)
class DescribedObject:
    """An object: its number in packets, shape, size (m; of a cylinder twice its diameter, then its length), colour.

    `first` is where it is in the beginning. `turns`: by how many equal turns about its z it looks the same. `carries`:
    what may be put on it; `*`: everything. `hangs`: nothing has to be beneath it.
    `threads`: how long those are on which it hangs (m), and the names of their boxes; None: it does not swing.
    """

    name: str
    number: int
    shape: str
    size: Three
    colour: Three
    first: Placed
    grasps: tuple[Grasp, ...]
    turns: int = 1
    carries: tuple[str, ...] = ()
    hangs: bool = False
    threads: tuple[float, tuple[str, ...]] | None = None

    def solid(self, pose: Matrix) -> Solid:
        """Return the box around it at a pose (4 x 4)."""
        return Solid(pose, (self.size[0] / 2, self.size[1] / 2, self.size[2] / 2))

    def standing(self, rotation: Matrix, x: float, y: float, height: float) -> Matrix:
        """Return the pose (4 x 4) at which it stands at a height, so turned (3 x 3)."""
        pose = np.eye(4)
        pose[:3, :3], pose[:2, 3] = rotation, (x, y)
        pose[2, 3] = height - self.solid(pose).bottom
        return pose


@dataclass(frozen=True, eq=False)
class ObjectTable:
    """All objects of an arm, and the table where they are put.

    `box`: where objects may be, for their packets. `area`: two corners (x, y) of the table's free part, `height` its
    surface. `fingers`: two corners in the tool's frame of the room that the open gripper takes. `release`: how far
    above a surface it opens; below zero where objects are pressed on. `lift`: how far it lifts, straight up. `slow`:
    the share of full speed of straight ways to and from objects; None: as other motions. `plate`: one with studs, where
    there is one. `hand`: boxes (two corners) in the tool's frame behind which a camera does not see what it holds. All
    in m.
    """

    objects: Mapping[str, DescribedObject]
    box: Box
    area: tuple[tuple[float, float], tuple[float, float]]
    height: float
    fingers: tuple[Three, Three]
    release: float
    lift: float
    slow: float | None
    plate: Plate | None = None
    hand: tuple[tuple[Three, Three], ...] = ()

    def named(self, name: str) -> DescribedObject | None:
        """Return the object of that name, or None."""
        return self.objects.get(name)

    def first(self) -> dict[str, Placed]:
        """Return where the objects are in the beginning, by name."""
        return {name: one.first for name, one in self.objects.items()}

    def fingers_at(self, tool: Matrix) -> Solid:
        """Return the room that the open gripper takes with its tool at a pose (4 x 4)."""
        low, high = (np.array(corner) for corner in self.fingers)
        pose = tool.copy()
        pose[:3, 3] = (tool @ np.append((low + high) / 2, 1.0))[:3]
        half = (high - low) / 2
        return Solid(pose, (float(half[0]), float(half[1]), float(half[2])))

    def is_free(self, x: float, y: float) -> bool:
        """Return whether a point is in the free part of the table."""
        (x0, y0), (x1, y1) = self.area
        return x0 <= x <= x1 and y0 <= y <= y1


def pose_of(placed: Placed) -> Matrix:
    """Return the pose (4 x 4) of a place."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat(placed.rotation).as_matrix()
    pose[:3, 3] = placed.place
    return pose


def placed_of(pose: Matrix, held: bool = False) -> Placed:
    """Return a pose (4 x 4) as a place."""
    x, y, z = (float(v) for v in pose[:3, 3])
    a, b, c, d = (float(v) for v in Rotation.from_matrix(pose[:3, :3]).as_quat())
    return Placed((x, y, z), (a, b, c, d), held)


def yaw_of(pose: Matrix) -> float:
    """Return by how much (rad) the x axis of a pose is turned about the vertical."""
    return float(np.arctan2(pose[1, 0], pose[0, 0]))


def upright(pose: Matrix, yaw: float = 0.0) -> Matrix:
    """Return a rotation (3 x 3) without a lean of up to a degree, and with this turn about the vertical (rad)."""
    rest = Rotation.from_euler("z", -yaw_of(pose)).as_matrix() @ pose[:3, :3]
    nearest = np.round(rest)
    straight = np.abs(rest - nearest).max() < pi / 180 and abs(np.linalg.det(nearest) - 1.0) < 1e-9
    return np.asarray(Rotation.from_euler("z", yaw).as_matrix() @ (nearest if straight else rest))


@cache
def objects_of(driver: str) -> ObjectTable:
    """Return the objects of a robot, from its `robot.toml`. Raises BadDescription."""
    return object_table(load(driver))


def object_facts(driver: str) -> dict[str, Any]:
    """Return what a browser needs to draw a robot's objects, to read their packets and to aim at them.

    Lengths in m, poses 4 x 4 row by row: `first` in the base's frame, `grasps` of the tool in the object's.

    Raises:
        BadDescription: the tables of objects are not valid.

    """
    table = objects_of(driver)
    objects = [
        {
            "name": o.name, "number": o.number, "shape": o.shape, "size": o.size, "colour": o.colour, "turns": o.turns,
            "carries": o.carries, "first": pose_of(o.first).ravel().tolist(), "hangs": o.hangs,
            "grasps": [grasp.tool.ravel().tolist() for grasp in o.grasps],
        }
        for o in table.objects.values()
    ]  # fmt: skip
    box = {"low": table.box.low, "size": table.box.size}
    facts = {"objects": objects, "objects_box": box, "release_m": table.release, "table_m": table.height}
    if (plate := table.plate) is not None:
        x, y, z = plate.place
        facts["plate"] = {"place": [x, y, z], "studs": plate.studs, "pitch": plate.pitch, "thick": plate.thick}
    return facts


def object_table(description: Mapping[str, Any]) -> ObjectTable:
    """Return the objects of a description. Raises BadDescription."""
    common, listed = table_of(description, "objects"), description.get("object", ())
    if not isinstance(listed, Sequence) or not 0 < len(listed) <= MOST:
        raise BadDescription(f"1 to {MOST} tables [[object]] are needed")
    box, area = _box(common), common.get("area", ())
    if not isinstance(area, Sequence) or len(area) != 2:
        raise BadDescription("objects: area needs two corners [x, y]")
    low, high = (numbers("objects", {"area": corner}, "area", 2) for corner in area)
    if not all(a < b for a, b in zip(low, high, strict=True)):
        raise BadDescription("objects: the first corner of area lies below the second")
    fingers = tuple(three("objects", common, name) for name in ("fingers_low", "fingers_high"))
    if not all(a < b for a, b in zip(*fingers, strict=True)):
        raise BadDescription("objects: fingers_low lies below fingers_high")
    slow = number("objects", common, "slow") if "slow" in common else None
    hand = [tuple(three("objects", {"hand": corner}, "hand") for corner in one) for one in common.get("hand", ())]
    if not all(len(corners) == 2 and all(a < b for a, b in zip(*corners, strict=True)) for corners in hand):
        raise BadDescription("objects: each box of hand has two corners, the first below the second")
    objects = [_object(number, one) for number, one in enumerate(listed)]
    if len({one.name for one in objects}) != len(objects):
        raise BadDescription("two objects have the same name")
    known = {one.name: one for one in objects}
    for one in objects:
        if strange := [name for name in one.carries if name not in known and name != "*"]:
            raise BadDescription(f"object {one.name}: carries names {strange[0]!r}, which is none of the objects")
        _inside(box, one)
    return ObjectTable(
        known, box, ((low[0], low[1]), (high[0], high[1])), number("objects", common, "height"),
        (fingers[0], fingers[1]), number("objects", common, "release", 0.001), number("objects", common, "lift", 0.1),
        slow, plate_in(description), tuple((low, high) for low, high in hand),
    )  # fmt: skip


def _inside(box: Box, one: DescribedObject) -> None:
    ends = zip(one.first.place, box.low, box.size, strict=True)
    if not all(low <= at <= low + size for at, low, size in ends):
        raise BadDescription(f"object {one.name}: its first place is outside the box of objects")


def _box(common: Mapping[str, Any]) -> Box:
    try:
        return Box(three("objects", common, "low"), three("objects", common, "size"))
    except ValueError as error:
        raise BadDescription(f"objects: {error}") from error


def _object(number: int, table: Any) -> DescribedObject:
    name = table.get("name") if isinstance(table, Mapping) else None
    if not isinstance(name, str) or not NAME.fullmatch(name) or name.lower() in RESERVED:
        raise BadDescription(
            f"object {number + 1} needs a name of letters, digits and hyphens that is no word of tasks"
        )
    who, shape = f"object {name}", table.get("shape")
    if shape not in SHAPES:
        raise BadDescription(f"{who}: shape is {' or '.join(SHAPES)}")
    size, colour = three(who, table, "size"), three(who, table, "colour")
    if not all(0.0 < edge <= LARGEST_M for edge in size) or (shape == "cylinder" and size[0] != size[1]):
        raise BadDescription(f"{who}: size is three edges up to {LARGEST_M:g} m; of a cylinder diameter twice, length")
    if not all(0.0 <= part <= 1.0 for part in colour):
        raise BadDescription(f"{who}: colour is three numbers from 0 to 1")
    turns, carries = whole(who, table, "turns", 1, 36, 1), table.get("carries", ())
    if not isinstance(carries, Sequence) or isinstance(carries, str) or not all(isinstance(c, str) for c in carries):
        raise BadDescription(f"{who}: carries is a list of names, or of a star")
    first = placed_of(pose(who, table, "place", "rpy_deg"))
    grasps = tuple(_grasp(who, one) for one in table.get("grasp", ()))
    if not grasps:
        raise BadDescription(f"{who}: it needs at least one [[object.grasp]]")
    return DescribedObject(
        name,
        number,
        shape,
        size,
        colour,
        first,
        grasps,
        turns,
        tuple(carries),
        table.get("hangs", False) is True,
        _threads(who, table, first),
    )


def _threads(who: str, table: Mapping[str, Any], first: Placed) -> tuple[float, tuple[str, ...]] | None:
    if "hangs_from" not in table:
        return None
    length, names = number(who, table, "hangs_from") - first.place[2], table.get("threads", ())
    if not length > 0.0 or not isinstance(names, Sequence) or not all(isinstance(name, str) for name in names):
        raise BadDescription(f"{who}: hangs_from is above its first place, threads are names of boxes")
    return length, tuple(names)


def _grasp(who: str, table: Any) -> Grasp:
    if not isinstance(table, Mapping):
        raise BadDescription(f"{who}: a grasp is a table")
    tool, away = pose(who, table, "tool", "rpy_deg"), three(who, table, "away")
    inverse = np.linalg.inv(tool)
    if not all(abs(at) < REACH_M for at in inverse[:3, 3]):
        raise BadDescription(f"{who}: a grasp holds it within {REACH_M:g} m of the tool")
    if not any(away):
        raise BadDescription(f"{who}: away is the way by which the tool comes, and not zero")
    return Grasp(tool, away)
