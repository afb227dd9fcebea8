"""Which robots are installed: the only place that looks through the entry points of all packages.

A robot is a package whose entry point in the group `farhand.drivers` names its driver's class, or the folder
`robots.drivers.NAME` of ours. One of the group `farhand.simulators` names the module of a simulator.
"""

from functools import cache
from importlib.metadata import entry_points


@cache
def _named(group: str, name: str) -> str:
    """Return what the entry point names, or an empty text; the search is slow, so it is done once a name."""
    return next((point.value for point in entry_points(group=group, name=name)), "")


def driver_path(name: str) -> str:
    """Return `module:class` of the driver called `name`, whether or not it is there."""
    return _named("farhand.drivers", name) or f"robots.drivers.{name}.driver:Driver"


def package(name: str) -> str:
    """Return the package in which the robot's files lie."""
    module = driver_path(name).partition(":")[0]
    return module.rpartition(".")[0] or module


def simulator_module(name: str) -> str:
    """Return the module to run for the address `sim:NAME`: an installed package's, or one that ships."""
    return _named("farhand.simulators", name) or f"simulators.{name}"


def packaged() -> list[str]:
    """Return the names of the drivers that come in packages of their own."""
    return [point.name for point in entry_points(group="farhand.drivers")]
