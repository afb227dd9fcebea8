"""The classic console's picture: what a robot offers that can be drawn and driven without scripts.

A robot has such a console where its folder has a module `panel` with the members of `Panel`
and a template `console/classic.html` with its buttons.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol, cast

from robots.description import folder
from robots.installed import package


@dataclass(frozen=True)
class Press:
    """What a press means: a command's kind and its values, which the service still checks."""

    kind: str
    args: dict[str, Any]


class Panel(Protocol):
    """A module that draws a robot as one picture and reads presses in it."""

    WIDTH: int  # of the picture, in pixels
    HEIGHT: int

    def press(self, x: int, y: int, still: int, description: dict[str, Any], scale: int = 1) -> Press | None:
        """Return what a press at (x, y) means in the picture shown `scale` times as large; None outside of it."""

    def form(self, fields: Mapping[str, str]) -> Press | None:
        """Return what the robot's own buttons and fields ask for; None where nothing was asked."""

    def compose(self, picture: Path | None, description: dict[str, Any], joints: list[float]) -> bytes:
        """Return the picture as a GIF: what the camera saw at `joints` (rad, m), the robot, its buttons."""


@cache
def panel_of(driver: str) -> Panel | None:
    """Return the robot's panel, None where it has none. Raises ImportError where its package is not installed."""
    if not folder(driver).joinpath("panel.py").is_file():
        return None
    return cast(Panel, import_module(f"{package(driver)}.panel"))
