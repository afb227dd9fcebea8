"""The former places of the kit's modules, for robot packages written for version 0.1; version 1.0 removes them."""

import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

KIT = "robots.kit."
PLACES = {
    "robots.addresses": KIT + "addresses",
    "robots.autonomy": KIT + "rovers",
    "robots.autonomy.compiled": KIT + "compiled",
    "robots.autonomy.ratslam": KIT + "slam",
    "robots.autonomy.gridmap.compass": KIT + "rovers.gridmap.scan",
    "robots.autonomy.gridmap.cones": KIT + "rovers.gridmap.plan",
    "robots.autonomy.gridmap.turns": KIT + "rovers.gridmap.scan",
    "robots.autonomy.local_map": KIT + "rovers.steering",
    "robots.autonomy.ratslam.matching": KIT + "slam.views",
    "robots.autonomy.ratslam.ready": KIT + "slam.slam",
    "robots.clock": KIT + "clock",
    "robots.conformance": KIT + "conformance",
    "robots.contract": KIT + "contract",
    "robots.description": KIT + "description",
    "robots.drivers": KIT + "drivers",
    "robots.drivers.errors": KIT + "contract.errors",
    "robots.files": KIT + "files",
    "robots.installed": KIT + "installed",
    "robots.messages": KIT + "packets",
    "robots.motion": KIT + "arms",
    "robots.motion.line": KIT + "arms.straight",
    "robots.opening": KIT + "opening",
    "robots.plain": KIT + "plain",
    "robots.previews": KIT + "previews",
    "robots.vision": KIT + "vision",
}


def present_name(name: str) -> str | None:
    """Return the name that a module has now; None if `name` is no former name."""
    head, tail = name, ""
    while head.count("."):
        if head in PLACES:
            return PLACES[head] + tail
        head, _, last = head.rpartition(".")
        tail = f".{last}{tail}"
    return None


class FormerPlaces(MetaPathFinder, Loader):
    """Imports a module by its former name: it is the same module object, so its classes are the same."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return a spec if the name is a former one."""
        if not fullname.startswith("robots.") or present_name(fullname) is None:
            return None
        return ModuleSpec(fullname, self)

    def exec_module(self, module: ModuleType) -> None:
        """Put the present module in the place of the one that is imported."""
        name = module.__name__
        present = str(present_name(name))
        warnings.warn(f"{name} is {present} now; the former name goes with 1.0.", DeprecationWarning, stacklevel=2)
        sys.modules[name] = import_module(present)


def install() -> None:
    """Make former names importable, before other finders: a folder left behind by an older version hides nothing."""
    if not any(isinstance(finder, FormerPlaces) for finder in sys.meta_path):
        sys.meta_path.insert(0, FormerPlaces())
