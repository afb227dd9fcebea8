"""Find a robot's spec, functions and driver by its driver's name.

The spec is the function `spec()` of the module `spec` beside the driver's module.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from importlib import import_module
from typing import Any

from robots.kit.contract.session import JSON, Session, Trace
from robots.kit.contract.spec import Spec
from robots.kit.description import load
from robots.kit.installed import driver_path, package


@cache
def spec_of(name: str) -> Spec:
    """Return the spec of the robot of that driver, with the plain words of its robot.toml; its driver is not loaded.

    Raises:
        LookupError: no such driver is installed, or its package is broken.

    """
    try:
        module = import_module(f"{package(name)}.spec")
        made: Spec = replace(module.spec(), words=load(name).get("words", {}))
    except ModuleNotFoundError as error:
        raise LookupError(f"no driver named {name!r} is installed") from error
    except Exception as error:  # whatever a package does wrong, other robots go on
        raise LookupError(f"the package of the driver {name!r} is broken: {error}") from error
    return made


def spec_or_none(name: str) -> Spec | None:
    """Return the same, or None where no such driver is installed."""
    try:
        return spec_of(name)
    except LookupError:
        return None


@cache
def function(path: str) -> Callable[..., Any]:
    """Return what a capability names as `package.module:name`."""
    module, _, name = path.partition(":")
    found: Callable[..., Any] = getattr(import_module(module), name)
    return found


def open_session(name: str, address: str, settings: JSON, trace: Trace | None = None) -> Session:
    """Return the robot's session; nothing is opened before its `connect`.

    Raises:
        LookupError: no such driver is installed, or a library that it needs is missing.

    """
    spec_of(name)
    made: Session = function(driver_path(name))(address, settings, trace)
    return made
