"""The spec of the hall rover; readable without its driver."""

from enum import StrEnum
from math import pi
from typing import Any

from robots.kit.contract.capabilities import (
    Check,
    FloorPlan,
    Idle,
    JobMovies,
    Preview,
    PrivacyMasks,
    Programs,
    Reset,
    Setting,
    Share,
    Statistics,
    Times,
    Total,
)
from robots.kit.contract.channels import IN_PLANE, Scalar, Scale
from robots.kit.contract.policies import Bound, Policies, Range
from robots.kit.contract.spec import ANYONE, STAFF, TURN, Argument, CommandKind, Spec
from robots.kit.contract.streams import Stream
from robots.kit.description import load
from robots.kit.drivers.srv1.missions import LIMIT_S, LONGEST
from robots.kit.drivers.srv1.rules import paper
from robots.kit.rovers.fuzzy_text import LONGEST as LONGEST_RULES

SLICE_S = 60.0
GO_S = 300.0  # two looks around, and the longest way through the hall slowly
HAND_LONGEST_S = 120.0
TURN_S = 20.0
RULES_S = 30.0  # three uploads, by radio
LOOK_S = 240.0  # three times around, by radio
MOST = 65_535  # of a CRC-16
BY_DRIVER, BY_ALL = frozenset({TURN, STAFF}), frozenset({TURN, ANYONE})
STATISTICS = Statistics(
    rows=(
        Total("Driven, by odometry", "driven"),
        Times("Places reached", "go"),
        Times("Places not reached", "go", failed=True),
        Share("Time on patrol", ("patrol",)),
    ),
    over_time="battery", job="place", done="reached",
)  # fmt: skip


class Mode(StrEnum):
    """The words of `RobotState.mode`."""

    RESTING = "resting"
    HAND = "driven by hand"
    GOING = "going to a place"
    TURNING = "turning"
    PATROL = "on patrol"
    WAITING = "waiting for a free way"


def spec() -> Spec:
    """Return the spec, from the description."""
    description = load("srv1")
    hall, battery = description["hall"], description["battery"]
    permitted = Policies(on_link_lost=_permitted(description))
    ranges = [(name, description[name]) for name in ("infrared", "sonar")]
    return Spec(
        name=description["name"],
        rest_s=description["line"]["rest_s"],
        pose=IN_PLANE,
        modes=tuple(Mode),
        channels=(
            *(Scalar(name, "m", table["near"], table["far"]) for name, table in ranges),
            Scalar("compass", "°", 0.0, 360.0),
            Scalar("spread", "m", 0.0, 1.0),
            Scalar("driven", "m", 0.0, 1e6),
            Scalar("battery", "V", battery["empty"], battery["full"]),
            Scalar("temperature", "°C", 0.0, 50.0),
            Scalar("humidity", "%", 0.0, 100.0),
            Scalar("light", "%", 0.0, 100.0),
            Scalar("presence", "", 0.0, 1.0),
            Scalar("rules", "", 0.0, MOST),
        ),
        streams=(Stream("unseen", "application/json"),),
        scales=_scales(hall),
        capabilities=(
            Reset("Connect again"), Idle("patrol", SLICE_S), Check("robots.kit.drivers.srv1.checks:check"), STATISTICS,
            Programs("mission", "mission"), Preview("robots.kit.drivers.srv1.checks:foresee"),
            FloorPlan("robots.kit.drivers.srv1.checks:floor_plan"), JobMovies(("go",)), PrivacyMasks(),
            Setting(
                "permit_s", "It drives on by itself", unit="s", low=0.0, high=description["line"]["longest_permit_s"],
                default=description["line"]["permit_s"],
                help="On patrol, for at most so long while nothing reaches it. 0: it rests at once.",
            ),
            Setting(
                "beacon", "Beacon on the hall's tower", low=0.0, high=1.0, default=float(hall.get("beacon", False)),
                help="1: the tower tells the rover range and bearing, for a hall in which showcases are moved. 0: there"
                " is none.",
            ),
        ),
        commands=(
            CommandKind(
                "drive", "Drive by hand", (Argument("forward", "", -1.0, 1.0), Argument("turn", "", -1.0, 1.0)),
                limit_s=HAND_LONGEST_S, still_after=False, held=True, steered=True,
            ),
            CommandKind(
                "go", "Go to a place",
                (Argument("x", "m", 0.0, hall["width"], label="from the left wall"),
                 Argument("y", "m", 0.0, hall["depth"], label="from the lower wall")),
                limit_s=GO_S, asked_by=BY_ALL, still_after=False,
            ),
            CommandKind(
                "turn", "Turn in place",
                (Argument("angle", "rad", -pi, pi, label="to the left", directions=("to the left", "to the right")),),
                limit_s=TURN_S, still_after=False,
            ),
            CommandKind(
                "look", "Look where it is", limit_s=LOOK_S, asked_by=BY_DRIVER, still_after=False,
            ),
            CommandKind(
                "patrol", "Patrol", limit_s=SLICE_S, asked_by=BY_DRIVER, still_after=False, policies=permitted,
            ),
            CommandKind(
                "mission", "Mission", (Argument("text", "", 1, LONGEST, text=True, label="steps, one a line"),),
                limit_s=LIMIT_S, asked_by=BY_ALL, still_after=False, policies=permitted,
            ),
            CommandKind(
                "rules", "Rules of the patrol",
                (Argument(
                    "text", "", 1, LONGEST_RULES, text=True, label="rule set",
                    number="robots.kit.drivers.srv1.rules:number_of",
                ),),
                limit_s=RULES_S, lane="config", asked_by=BY_DRIVER, default={"text": paper()}, shown={"text": "rules"},
                moves=False, still_after=False,
            ),
        ),
    )  # fmt: skip


def _permitted(description: dict[str, Any]) -> Bound:
    """Return inside what the rover may go on by itself while nobody reaches it."""
    hall, motion = description["hall"], description["motion"]
    return Bound(
        float(description["line"]["permit_s"]), (Range("x", 0.0, hall["width"]), Range("y", 0.0, hall["depth"])),
        speed=1.1 * motion["most_speed"], turn=motion["turn"], setting="permit_s",
    )  # fmt: skip


def _scales(hall: dict[str, Any]) -> dict[str, Scale]:
    wide = max(hall["width"], hall["depth"])
    return {
        "x": Scale(-wide, 2 * wide, 0.002), "y": Scale(-wide, 2 * wide, 0.002), "heading": Scale(-pi, pi, 0.002),
        "infrared": Scale(0.0, 1.0, 0.005), "sonar": Scale(0.0, 12.0, 0.01), "spread": Scale(0.0, 10.0, 0.01),
        "compass": Scale(0.0, 360.0, 0.1),
        "driven": Scale(0.0, 1e6, 0.01), "battery": Scale(0.0, 10.0, 0.01), "temperature": Scale(-20.0, 60.0, 0.1),
        "humidity": Scale(0.0, 100.0, 0.1), "light": Scale(0.0, 100.0, 0.1), "presence": Scale(0.0, 1.0, 1.0),
        "rules": Scale(0.0, MOST, 1.0),
    }  # fmt: skip
