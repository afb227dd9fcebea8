"""The driver contract: what a robot's folder has to offer. Eight members.

A driver is found by its entry point (group ``farhand.drivers``) or as
``robots.drivers.<name>.driver:Driver``. Its constructor does no I/O. Units are SI.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any, Protocol

JSON = dict[str, Any]
OnStage = Callable[[str], None]
Permit = Callable[[], None]
Trace = Callable[[str, bytes, str], None]


@dataclass(frozen=True)
class Argument:
    """One value of a command: name, unit, inclusive range."""

    name: str
    unit: str
    low: float
    high: float
    required: bool = True


@dataclass(frozen=True)
class CommandKind:
    """A command a robot understands; `level` is the clearance it needs."""

    kind: str
    label: str
    arguments: tuple[Argument, ...] = ()
    level: int = 1
    limit_s: float = 15.0
    moves: bool = True
    still: bool = True  # a new stable picture belongs to its end


@dataclass(frozen=True)
class Features:
    """What the robot can do, readable before any connection."""

    name: str
    commands: tuple[CommandKind, ...]
    joints: tuple[str, ...]

    def command(self, kind: str) -> CommandKind | None:
        """Return the command of that kind, or None."""
        return next((c for c in self.commands if c.kind == kind), None)


@dataclass(frozen=True)
class RobotState:
    """What the hardware said. Joints in rad and m; pose (x, y, z, theta) in m and rad."""

    at: float
    joints: tuple[float, ...]
    pose: tuple[float, ...]
    moving: bool
    ready: bool
    fault: str = ""


@dataclass(frozen=True)
class Outcome:
    """What was really sent and where the robot is now."""

    sent: JSON = field(default_factory=dict)
    state: RobotState | None = None


class Driver(Protocol):
    """One robot behind one wire. `execute` blocks; `hold` may be called from any thread."""

    features: Features

    def connect(self) -> RobotState:
        """Open the wire and ask the hardware for its state. Raises HardwareFault."""

    def close(self) -> None:
        """Let go of the wire. Never raises."""

    def state(self) -> RobotState:
        """Ask the hardware. Raises HardwareFault."""

    def latest(self) -> RobotState | None:
        """Return the newest state heard, without asking."""

    def check(self, kind: str, args: JSON, pose: tuple[float, ...] | None = None) -> None:
        """Refuse what can be known to be wrong at `pose` (None: wherever the robot is).

        Opens nothing. Raises BadRequest, OutOfWorkspace.
        """

    def execute(self, kind: str, args: JSON, permit: Permit, on_stage: OnStage) -> Outcome:
        """Do it and wait for its end; `permit` is called right before every actuation.

        Raises whatever `permit` raises, Held, BadRequest, OutOfWorkspace, HardwareFault.
        """

    def hold(self) -> RobotState:
        """Bring the robot to rest now. Raises HardwareFault where that is not certain."""

    def recover(self, permit: Permit) -> RobotState:
        """Soft reset: reset the controller, recalibrate, return to the previous position."""


def make_driver(name: str, address: str, settings: JSON, trace: Trace | None = None) -> Driver:
    """Return the driver called `name` for `address`; nothing is opened yet.

    Raises:
        LookupError: no such driver is installed.

    """
    made: Driver = _factory(name)(address, settings, trace)
    return made


@cache
def _factory(name: str) -> Callable[..., Any]:
    """Return the driver's class; looking through all installed packages is slow, so once."""
    for point in entry_points(group="farhand.drivers", name=name):
        found: Callable[..., Any] = point.load()
        return found
    try:
        module = import_module(f"robots.drivers.{name}.driver")
    except (ModuleNotFoundError, ValueError) as error:
        raise LookupError(f"no driver named {name!r} is installed") from error
    driver: Callable[..., Any] = module.Driver
    return driver
