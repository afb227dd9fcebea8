"""The spec of a robot of the LeRobot library, from its `robot.toml`; LeRobot itself is not loaded."""

from dataclasses import dataclass
from functools import cache
from math import radians

from robots.kit.contract.capabilities import Reset
from robots.kit.contract.spec import Argument, CommandKind, Spec
from robots.kit.description import load

LIMIT_S = 30.0
REST_S = 1.5  # the longest wait for rest after a hold or the last goal
SCALES = {"deg": (radians(1.0), "rad"), "%": (0.01, "")}  # LeRobot's units in ours


@dataclass(frozen=True)
class Feature:
    """One value of an action: LeRobot's key and unit, our name, its range and speed in LeRobot's unit."""

    key: str
    unit: str = "%"
    low: float = -100.0  # LeRobot's scale of a calibrated range
    high: float = 100.0
    speed: float = 40.0
    ready: float = 0.0

    @property
    def name(self) -> str:
        """Return the name for people."""
        return self.key.removesuffix(".pos")

    @property
    def scale(self) -> float:
        """Return the size of LeRobot's unit in ours."""
        return SCALES[self.unit][0]

    def argument(self) -> Argument:
        """Return it as a value of a command."""
        return Argument(self.name, SCALES[self.unit][1], self.low * self.scale, self.high * self.scale, required=False)


@cache
def features(driver: str) -> tuple[Feature, ...]:
    """Return the values of an action in the order of `robot.toml`."""
    return tuple(Feature(**f) for f in load(driver)["lerobot"]["feature"])


def spec_from(driver: str) -> Spec:
    """Return the spec of the robot whose driver is called `driver`."""
    listed = features(driver)
    return Spec(
        name=load(driver)["name"],
        joints=tuple(f.name for f in listed),
        handover=("ready",),
        rest_s=REST_S,
        capabilities=(Reset("Connect again"),),
        commands=(
            CommandKind("move", "Move", tuple(f.argument() for f in listed), limit_s=LIMIT_S),
            CommandKind("ready", "Ready position", limit_s=LIMIT_S),
            CommandKind("noop", "No operation", limit_s=5.0, moves=False, still_after=False),
        ),
    )
