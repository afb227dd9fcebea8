"""What is in the cell, as `robot.toml` describes it: bricks, their studs, the plate, the rod. Lengths in m."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robots.kit.description import load

Floats = NDArray[np.float64]
DRIVER = "puma"
PLATE = "plate"
STUD_RADIUS = 0.0048
PRINT_M = 0.024  # side of the square in the middle of a brick that is flat, because a marker is printed there


@dataclass(frozen=True, eq=False)
class Thing:
    """An object of the cell: the edges of its box (m), colour (0 to 1), pose at the start (4 x 4)."""

    name: str
    size: tuple[float, float, float]
    colour: tuple[float, float, float]
    first: Floats


@dataclass(frozen=True, eq=False)
class Bearer:
    """A body with studs on its top, or the plate: half edges (m), and the middles of its studs (n, 2) in its frame."""

    name: str
    half: tuple[float, float, float]
    studs: Floats


@cache
def things() -> dict[str, Thing]:
    """Return bricks and rod by name."""
    return {one["name"]: _thing(one) for one in load(DRIVER)["object"]}


def _thing(table: dict[str, Any]) -> Thing:
    first = np.eye(4)
    first[:3, :3] = Rotation.from_euler("xyz", table.get("rpy_deg", [0.0, 0.0, 0.0]), degrees=True).as_matrix()
    first[:3, 3] = table["place"]
    return Thing(table["name"], tuple(table["size"]), tuple(table["colour"]), first)


@dataclass(frozen=True, eq=False)
class Print:
    """A marker on a thing: its number, the side of its print with the white margin (m), where in the thing's frame."""

    number: int
    printed: float
    middle: Floats
    right: Floats
    upward: Floats


CELLS = 6  # of a marker's side: four bits and the border on both sides; its white margin is half a cell


def prints(name: str) -> tuple[Print, ...]:
    """Return the markers on a thing."""
    (thing,) = (one for one in load(DRIVER)["object"] if one["name"] == name)
    return tuple(
        Print(
            one["number"], one["side"] * (CELLS + 1) / CELLS, *(np.array(one[v]) for v in ("middle", "right", "upward"))
        )
        for one in thing.get("markers", ())
    )


def bricks() -> tuple[str, ...]:
    """Return the bricks' names."""
    return tuple(one["name"] for one in load(DRIVER)["object"] if one["shape"] == "box")


def plate_place() -> Floats:
    """Return the middle of the plate (m)."""
    table = load(DRIVER)["plate"]
    x, y, z = table["place"]
    return np.array([x, y, z + table["thick_m"] / 2])


def _grid(x: int, y: int, pitch: float) -> Floats:
    rows, columns = (pitch * (np.arange(n) - (n - 1) / 2) for n in (x, y))
    return np.stack(np.meshgrid(rows, columns, indexing="ij"), axis=-1).reshape(-1, 2)


@cache
def bearers() -> tuple[Bearer, ...]:
    """Return everything that has studs: the bricks in their order, then the plate."""
    plate, pitch = load(DRIVER)["plate"], float(load(DRIVER)["plate"]["pitch_m"])
    found = []
    for name in bricks():
        x, y, z = (edge / 2 for edge in things()[name].size)
        studs = _grid(round(2 * x / pitch), round(2 * y / pitch), pitch)
        studs = studs[np.abs(studs).max(axis=1) > PRINT_M / 2]
        found.append(Bearer(name, (x, y, z), studs))
    x, y = (n * pitch / 2 for n in plate["studs"])
    found.append(
        Bearer(PLATE, (x, y, plate["thick_m"] / 2), _grid(int(plate["studs"][0]), int(plate["studs"][1]), pitch))
    )
    return tuple(found)
