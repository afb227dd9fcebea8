"""The picture of the classic console, which is drawn and used without scripts.

A robot has a classic console if its folder has a module `panel` with the members of `Panel` and a template
`console/classic.html` with its buttons.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol, cast

from robots.kit.description import folder
from robots.kit.installed import package


@dataclass(frozen=True)
class Press:
    """The meaning of a press: a kind of command and its values, which the service still checks."""

    kind: str
    args: dict[str, Any]


class Panel(Protocol):
    """A module that draws a robot as one picture and reads presses in it."""

    WIDTH: int  # of the picture, in pixels
    HEIGHT: int

    def press(self, x: int, y: int, still: int, description: dict[str, Any], scale: int = 1) -> Press | None:
        """Return the meaning of a press at (x, y) in the picture shown `scale` times as large; None outside."""

    def form(self, fields: Mapping[str, str]) -> Press | None:
        """Return the command of the robot's own buttons and fields; None if there is none."""

    def compose(self, picture: Path | None, description: dict[str, Any], joints: list[float]) -> bytes:
        """Return the picture as a GIF: what the camera saw at `joints` (rad, m), the robot, its buttons."""


@cache
def panel_of(driver: str) -> Panel | None:
    """Return the robot's panel, None if it has none. Raises ImportError if its package is not installed."""
    if not folder(driver).joinpath("panel.py").is_file():
        return None
    return cast(Panel, import_module(f"{package(driver)}.panel"))
