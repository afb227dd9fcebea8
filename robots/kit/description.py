"""Loads a robot's description: `robot.toml` beside its driver, and other files of its folder."""

import tomllib
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any

from robots.kit.installed import package

CODING = "vp8"  # of live video, if the robot names none


@cache
def folder(driver: str) -> Traversable:
    """Return the robot's folder. Raises ImportError if its package is not installed."""
    return files(package(driver))


@cache
def load(driver: str) -> dict[str, Any]:
    """Return the parsed `robot.toml` of the driver package named `driver`.

    Raises:
        FileNotFoundError: no such robot folder.

    """
    text = folder(driver).joinpath("robot.toml").read_text("utf-8")
    return tomllib.loads(text)


def text_of(driver: str, name: str) -> str:
    """Return the text of a file in the robot's folder (`orientation.md`, `clearance.toml`)."""
    return folder(driver).joinpath(name).read_text("utf-8")


def views(description: dict[str, Any]) -> tuple[str, ...]:
    """Return the names of the robot's cameras; stills come from the first."""
    return tuple(description["camera"].get("views", ("camera",))) if "camera" in description else ()


def coding(description: dict[str, Any]) -> str:
    """Return the coding of the robot's live video: `vp8`, or `vp9` where fewer bytes are worth more work."""
    return str(description.get("camera", {}).get("video_coding", CODING))


def programs_of(driver: str, kind: str = "") -> list[tuple[str, str]]:
    """Return (name, text) of the robot's own programs, `programs/*.txt`; the first line has the name.

    Those of a further language are in `programs/KIND/*.txt`, where `kind` is the command that runs them.
    """
    kept = folder(driver).joinpath("programs", *((kind,) if kind else ()))
    if not kept.is_dir():
        return []
    found = []
    for file in sorted((f for f in kept.iterdir() if f.is_file()), key=lambda f: f.name):
        head, _, text = file.read_text("utf-8").partition("\n")
        found.append((head.removeprefix("#").strip(), text.strip()))
    return found
