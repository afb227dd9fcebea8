"""Builds an arm from its files: `model.urdf`, and the tables `arm`, `motion`, `limb` and `box` of `robot.toml`."""

from dataclasses import asdict
from functools import cache
from typing import TYPE_CHECKING, Any

from robots.kit.description import load, text_of

if TYPE_CHECKING:
    import numpy as np

    from robots.kit.arms.chain import Chain
    from robots.kit.arms.planner import Planner
    from robots.kit.arms.zones import Box, Limb, Zones


@cache
def chain(driver: str) -> "Chain":
    """Return the arm of the robot's `model.urdf`, up to the link that `robot.toml` calls its tip."""
    from robots.kit.arms.chain import Chain  # noqa: PLC0415 - slow to import, and not every robot is such an arm

    return Chain.from_urdf(text_of(driver, "model.urdf"), load(driver)["arm"]["tip"])


def boxes(description: dict[str, Any]) -> "tuple[Box, ...]":
    """Return the robot's own forbidden boxes (m)."""
    from robots.kit.arms.zones import Box  # noqa: PLC0415 - see chain

    return tuple(Box(b["name"], tuple(b["low"]), tuple(b["high"])) for b in description.get("box", ()))


def zones(driver: str, forbidden: "tuple[Box, ...] | None" = None) -> "Zones":
    """Return the robot's limbs among its own forbidden boxes, or among the given ones."""
    from robots.kit.arms.zones import Zones  # noqa: PLC0415 - see chain

    description, arm = load(driver), chain(driver)
    return Zones(arm, limbs(description, arm), boxes(description) if forbidden is None else forbidden)


def limbs(description: dict[str, Any], arm: "Chain") -> "list[Limb]":
    """Return the capsules of `[[limb]]`, each with the number of the joint that moves it."""
    from robots.kit.arms.zones import Limb  # noqa: PLC0415 - see chain

    return [
        Limb(
            b["name"], arm.names.index(b["joint"]), tuple(b["begin"]), tuple(b["end"]), b["radius"],
            tuple(b.get("spared", ())),
        )
        for b in description["limb"]
    ]  # fmt: skip


def posture(description: dict[str, Any], name: str) -> "np.ndarray[Any, np.dtype[np.float64]]":
    """Return a named posture of `[arm]` (`home`, `ready`) as joints in rad."""
    import numpy as np  # noqa: PLC0415 - pages read descriptions too, and need no arrays

    return np.radians(np.array(description["arm"][f"{name}_deg"], dtype=np.float64))


def planner(driver: str, forbidden: "tuple[Box, ...] | None" = None) -> "Planner":
    """Return the planner of the robot's arm, among its own forbidden boxes or the given ones."""
    from robots.kit.arms.path import Limits as PathLimits  # noqa: PLC0415 - see chain
    from robots.kit.arms.planner import Planner  # noqa: PLC0415 - see chain

    arm, motion = chain(driver), load(driver)["motion"]
    limits = PathLimits.of(arm, motion["acceleration_s"])
    return Planner(arm, zones(driver, forbidden), limits, motion["clearance_m"])


def model_facts(driver: str, address: str) -> dict[str, Any]:
    """Return what a browser needs to draw the robot from the URDF at `address`, and to plan its motions itself."""
    described = load(driver)
    return {
        "model": address,
        "tip": described["arm"]["tip"],
        "posture": posture(described, "ready").tolist(),
        **motion_facts(described, chain(driver)),
    }


def motion_facts(description: dict[str, Any], arm: "Chain") -> dict[str, Any]:
    """Return what a planner of the arm needs, as `ArmFacts` of frontend/src/motion/facts.ts reads it.

    The URDF is read once, here, so that both planners compute with the same numbers: lengths in m, angles in rad, poses
    4 x 4 row by row, and with the robot's own forbidden boxes.
    """
    motion = description["motion"]
    return {
        "joints": [
            {
                "name": j.name, "low": j.low, "high": j.high, "velocity": j.velocity,
                "origin": j.origin.ravel().tolist(), "axis": j.axis.tolist(),
            }
            for j in arm.joints
        ],
        "boxes": [asdict(box) for box in boxes(description)],
        "motion": {
            "tool": arm.tool.ravel().tolist(),
            "limbs": [asdict(limb) for limb in limbs(description, arm)],
            **{name: motion[name] for name in ("clearance_m", "acceleration_s", "scale", "scale_range", "limit_s")},
        },
    }  # fmt: skip
