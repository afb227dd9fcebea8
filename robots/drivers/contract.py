"""The driver contract: what a robot's folder has to offer. Eight members.

A driver is found by its entry point (group ``farhand.drivers``) or as
``robots.drivers.<name>.driver:Driver``. Its constructor does no I/O. Units are SI.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any, Protocol, runtime_checkable

JSON = dict[str, Any]
OnStage = Callable[[str], None]
Permit = Callable[[], None]
Trace = Callable[[str, bytes, str], None]


@dataclass(frozen=True)
class Argument:
    """One value of a command: name, unit, inclusive range; of a text, of its length."""

    name: str
    unit: str
    low: float
    high: float
    required: bool = True
    text: bool = False


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
    held: bool = False  # lives from keep-alives: it goes on until the controls are let go
    replaceable: bool = False  # a newer one of its like takes its place in motion; its driver asks `permit` on the way


@dataclass(frozen=True)
class Features:
    """What the robot can do, readable before any connection."""

    name: str
    commands: tuple[CommandKind, ...]
    joints: tuple[str, ...]
    handover: tuple[str, ...] = ()  # commands that put it in order between two turns

    def command(self, kind: str) -> CommandKind | None:
        """Return the command of that kind, or None."""
        return next((c for c in self.commands if c.kind == kind), None)


@dataclass(frozen=True)
class RobotState:
    """What the hardware said. Joints in rad and m; pose (x, y, z, angles...) in m and rad.

    A robot that knows them adds each joint's velocity (rad/s, m/s), the torque applied (N m, N)
    and its controller's own word for what it is doing.
    """

    at: float
    joints: tuple[float, ...]
    pose: tuple[float, ...]
    moving: bool
    ready: bool
    fault: str = ""
    velocities: tuple[float, ...] = ()
    torques: tuple[float, ...] = ()
    mode: str = ""


@dataclass(frozen=True)
class Outcome:
    """What was really sent and where the robot is now."""

    sent: JSON = field(default_factory=dict)
    state: RobotState | None = None


@dataclass(frozen=True)
class Preview:
    """Where a command would lead, before it is given: nothing is opened, nothing moves.

    `joints` at its end and `ways` on the way there (rad, m), `hand` the way of the hand
    ((x, y, z) in m), `seconds` on the way, `steps` which of a program's steps each of `ways`
    belongs to.
    """

    joints: tuple[float, ...]
    ways: tuple[tuple[float, ...], ...]
    hand: tuple[tuple[float, ...], ...]
    seconds: float
    steps: tuple[int, ...] = ()


@runtime_checkable
class Previews(Protocol):
    """A driver that can say where a command would lead; not every robot's can."""

    def preview(self, kind: str, args: JSON, joints: tuple[float, ...]) -> Preview:
        """Return where the command would lead from `joints`, at rest. Raises BadRequest, OutOfWorkspace."""


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

        `on_stage` is told "sent", then "acknowledged" once the robot has understood: from then
        on the deadline to begin is kept. Telling may take as long as a store takes, so no lock
        that `hold` needs may be held meanwhile; `permit` asks memory only until then.

        Where a command is replaceable, `permit` is called on its way too, and raises Replaced
        when the robot is to be left in motion for the target that comes next. A hold that
        another thread asks for meanwhile ends it for good with Held, whatever `permit` says.

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
