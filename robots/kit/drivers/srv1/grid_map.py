"""The hall of `robot.toml` as the stored map of the grid scan (`robots.kit.rovers.grid`)."""

from collections.abc import Mapping
from functools import cache
from typing import Any

from robots.kit.description import load
from robots.kit.rovers.gridmap.plan import Plan, RangeSensor
from robots.kit.rovers.gridmap.range_map import BINS, CELL_M, RangeMap

RAY_RAD = 0.01  # half of the cone that stands for a narrow ray


def plan_of(hall: Mapping[str, Any]) -> Plan:
    """Return the walls, showcases and exhibits of a description's table `hall`."""
    cases = hall.get("case", ())
    return Plan.of(
        hall["width"], hall["depth"],
        [(*case["at"], *case["half"]) for case in cases],
        [(*exhibit["at"], exhibit["radius"]) for exhibit in hall.get("exhibit", ())],
        [number for number, case in enumerate(cases) if case.get("black")],
    )  # fmt: skip


def sensors() -> tuple[RangeSensor, RangeSensor]:
    """Return sonar and infrared."""
    known = load("srv1")
    sonar, infrared = known["sonar"], known["infrared"]
    return (
        RangeSensor(sonar["from"][0], sonar["near"], sonar["far"], sonar["half_cone"], sonar["noise"]),
        RangeSensor(infrared["from"][0], infrared["near"], infrared["far"], RAY_RAD, infrared["noise"]),
    )


@cache
def range_map(cell: float = CELL_M, bins: int = BINS) -> RangeMap:
    """Return the rover's map in cells; made once a process, in a fraction of a second."""
    return RangeMap.of(plan_of(load("srv1")["hall"]), *sensors(), cell, bins)
