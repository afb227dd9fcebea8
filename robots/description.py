"""Load a robot's description: `robot.toml` beside its driver, and what follows from it."""

import tomllib
from functools import cache
from importlib.resources import files
from math import radians
from typing import Any

from robots.motion.scara import Limits, Scara


@cache
def load(driver: str) -> dict[str, Any]:
    """Return the parsed `robot.toml` of the driver package named `driver`.

    Raises:
        FileNotFoundError: no such robot folder.

    """
    text = files(f"robots.drivers.{driver}").joinpath("robot.toml").read_text("utf-8")
    return tomllib.loads(text)


def text_of(driver: str, name: str) -> str:
    """Return the text of a file of the robot's folder (`orientation.md`, `clearance.toml`)."""
    return files(f"robots.drivers.{driver}").joinpath(name).read_text("utf-8")


def scara(description: dict[str, Any]) -> Scara:
    """Return the arm's kinematics from its description (SI units)."""
    arm = description["arm"]
    return Scara(
        link1=arm["link1"],
        link2=arm["link2"],
        q1=Limits(*map(radians, arm["q1_deg"])),
        q2=Limits(*map(radians, arm["q2_deg"])),
        q3=Limits(*arm["q3"]),
        q4=Limits(*map(radians, arm["q4_deg"])),
        tool_angle=radians(arm["tool_angle_deg"]),
    )
