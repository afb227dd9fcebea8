"""The spec of the iRat; readable without its driver."""

from enum import StrEnum
from math import pi

from robots.kit.contract.capabilities import (
    Composite,
    GoodWhile,
    Idle,
    JobCheck,
    JobChoices,
    Need,
    Reset,
    Share,
    Statistics,
    Times,
    Total,
)
from robots.kit.contract.channels import IN_PLANE, Scalar, Scale
from robots.kit.contract.spec import ANYONE, STAFF, Argument, CommandKind, Spec
from robots.kit.contract.streams import Stream
from robots.kit.description import load

BY_STAFF, BY_ANYONE = frozenset({STAFF}), frozenset({ANYONE})
HAND_LONGEST_S = 60.0
SLICE_S = 60.0
CHARGE_S = 4 * 3600.0
FULL = 97.0  # percent; the last few take as long as all others
STATISTICS = Statistics(  # the rows of the paper's Table 1, its figures 8 and 9
    rows=(
        Total("Driven, by odometry", "driven"),
        Times("Recharges", "charge"),
        Times("Recharges that failed", "charge", failed=True),
        Share("Time roaming", ("goal", "explore")),
        Total("Maps cleared", "map"),
    ),
    ends=(("map_cleared", "Dropped, because the map was cleared"),),
    against="experiences",
    over_time="battery",
    job="goal",
    done="reached",
)
PLACES = JobChoices(
    "goal", "map", "robots.kit.drivers.irat.choices:choices", "Place on its map",
    "The robot knows no place yet. Come back when it has looked around.",
)  # fmt: skip
ON_ITS_MAP = GoodWhile("goal", "map", "map", "map_cleared", "The map was cleared, so this place is no longer known.")
SCENE = "robots.kit.drivers.irat.composites.scene:Scene"
COMPOSITES = (Composite("desktop", 780, 460, SCENE), Composite("phone", 320, 480, SCENE))  # the paper's sizes
SCALES = {
    "battery": Scale(0.0, 20.0, 0.01), "charge": Scale(0.0, 100.0, 0.1), "charging": Scale(0.0, 1.0, 1.0),
    "map": Scale(0.0, 100_000.0, 1.0), "experiences": Scale(0.0, 20_000.0, 1.0), "docks": Scale(0.0, 20_000.0, 1.0),
    "driven": Scale(0.0, 1e6, 0.01), "x": Scale(-30.0, 30.0, 0.001), "y": Scale(-30.0, 30.0, 0.001),
    "heading": Scale(-2 * pi, 2 * pi, 0.001),
}  # fmt: skip
ACROSS = "right of where its map began", "left of where its map began"
ALONG = "up from where its map began", "down from where its map began"
MOST = 16_777_216  # whole numbers that a channel's four bytes hold


class Mode(StrEnum):
    """The present activity of the robot; `RobotState.mode` tells it."""

    RESTING = "resting"
    EXPLORING = "exploring"
    GOAL = "going to somebody's goal"
    CHARGING = "charging"
    DOCKING = "going to the dock"
    STUCK = "stuck"
    HAND = "driven by hand"
    FLAT = "waiting for staff: battery"


def spec() -> Spec:
    """Return the spec, from the description."""
    description = load("irat")
    battery = description["battery"]
    place = (
        Argument("map", "", 1, MOST, whole=True, label="number of its map"),
        Argument("x", "m", -100.0, 100.0, label=ACROSS[0], directions=ACROSS),
        Argument("y", "m", -100.0, 100.0, label=ALONG[0], directions=ALONG),
        Argument("experience", "", 0, MOST, required=False, whole=True, label="place's number"),
    )
    share = Argument("forward", "", -1.0, 1.0), Argument("turn", "", -1.0, 1.0)
    return Spec(
        name=description["name"],
        rest_s=description["line"]["rest_s"],
        pose=IN_PLANE,
        scales=SCALES,
        modes=tuple(Mode),
        channels=(
            Scalar("battery", "V", battery["empty"], battery["full"]),
            Scalar("charge", "%", 0.0, 100.0),
            Scalar("charging", "", 0.0, 1.0),
            Scalar("map", "", 1.0, MOST),
            Scalar("experiences", "", 0.0, 10_000.0),
            Scalar("docks", "", 0.0, 10_000.0),
            Scalar("driven", "m", 0.0, 1e6),
        ),
        streams=(Stream("map", "application/x-irat-map"), Stream("cells", "application/x-irat-cells"),
                 Stream("earlier", "application/x-irat-earlier-map")),
        capabilities=(
            Reset("Connect again"),
            Idle("explore", SLICE_S), Need("charge", "charge", 100 * battery["low"], FULL), ON_ITS_MAP, STATISTICS,
            JobCheck("map", "robots.kit.drivers.irat.brain.places:check"), PLACES,
            *COMPOSITES,
        ),
        commands=(
            CommandKind(
                "goal", "Go to a place", place, limit_s=float(description["map"]["goal_s"]),
                asked_by=BY_ANYONE, still_after=False,
            ),
            CommandKind("explore", "Explore", limit_s=SLICE_S, asked_by=BY_STAFF, still_after=False),
            CommandKind("charge", "Charge", limit_s=CHARGE_S, asked_by=BY_STAFF, still_after=False),
            CommandKind(
                "drive", "Drive by hand", share, limit_s=HAND_LONGEST_S, asked_by=BY_STAFF, still_after=False,
                held=True,
            ),
            CommandKind(
                "clear_map", "Clear the map", asked_by=BY_STAFF, lane="config", moves=False, still_after=False,
            ),
            CommandKind(
                "pruning", "Prune the map (1) or clear it now and then (0)",
                (Argument("on", "", 0.0, 1.0, whole=True, label="choice"),),
                asked_by=BY_STAFF, lane="config", moves=False, still_after=False,
            ),
        ),
    )  # fmt: skip
