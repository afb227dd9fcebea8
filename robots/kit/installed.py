"""The installed robots: the only module that searches the entry points of all packages.

A robot is a package whose entry point in the group `farhand.drivers` names its driver class, or the folder
`robots.kit.drivers.NAME` of this project. An entry point in the group `farhand.simulators` names a simulator's module.
"""

from functools import cache
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path

SECRET = "FARHAND_SIMULATOR_SECRET"  # noqa: S105 - the variable of the environment in which a simulator is given one


@cache
def _named(group: str, name: str) -> str:
    """Return what the entry point names, or an empty text; cached, because the search is slow."""
    return next((point.value for point in entry_points(group=group, name=name)), "")


def driver_path(name: str) -> str:
    """Return `module:class` of the driver called `name`, whether it exists or not."""
    return _named("farhand.drivers", name) or f"robots.kit.drivers.{name}.driver:Driver"


def package(name: str) -> str:
    """Return the package that contains the robot's files."""
    module = driver_path(name).partition(":")[0]
    return module.rpartition(".")[0] or module


def simulator_module(name: str) -> str:
    """Return the module to run for the address `sim:NAME`, from an installed package or from this project."""
    return _named("farhand.simulators", name) or f"simulators.{name}"


def simulators() -> list[str]:
    """Return the names of installed simulators, of this project and of packages."""
    ours = find_spec("simulators")
    folders = ours.submodule_search_locations or () if ours else ()
    found = {p.parent.name for folder in folders for p in Path(folder).glob("*/__main__.py")}
    return sorted(found | {point.name for point in entry_points(group="farhand.simulators")})


def packaged() -> list[str]:
    """Return the names of drivers that come in packages of their own."""
    return [point.name for point in entry_points(group="farhand.drivers")]


def catalogues() -> list[Path]:
    """Return the folders `locale` of packages, which have translations of their texts; no package is imported."""
    found = set()
    for name in packaged():
        top, *rest = package(name).split(".")
        spec = find_spec(top)
        found |= {Path(folder, *rest, "locale") for folder in (spec and spec.submodule_search_locations) or ()}
    return sorted(folder for folder in found if folder.is_dir())


def drivers() -> list[str]:
    """Return the names of installed drivers, of this project and of packages."""
    ours = find_spec("robots.kit.drivers")
    folders = ours.submodule_search_locations or () if ours else ()
    found = {p.parent.name for folder in folders for p in Path(folder).glob("*/driver.py")}
    return sorted(found | set(packaged()))
