"""The spec of the Mercury arm; readable without its driver."""

from math import radians

from robots.kit.contract.capabilities import Calibration, Check, ClickInPicture, FloorPlan, Reset, ResultRow, Setting
from robots.kit.contract.channels import Pose, Scale
from robots.kit.contract.excavation import Excavation
from robots.kit.contract.planar import PlanarArm
from robots.kit.contract.spec import STAFF, Argument, CommandKind, Spec
from robots.kit.description import load
from robots.kit.drivers.mercury.beds import MOST_BEDS
from robots.kit.drivers.stills import stills

JOG_LONGEST_S = 20.0
HERE = "robots.kit.drivers.mercury"
MEASURED = tuple(
    row
    for height in ("up", "down")
    for row in (
        ResultRow(f"residual {height}", (height, "residual_mm"), "mm"),
        ResultRow(f"moves {height}", (height, "points")),
    )
)
BY_STAFF = frozenset({STAFF})
PUZZLE = (
    "Somebody made a bet, long ago, over a game in a club, and packed a bag in ten minutes. Each thing that you find is"
    " a stop on the way. A hint for those who keep a diary: count the days, then count them again."
)
ACROSS, ALONG = ("right", "left"), ("up", "down")  # as seen on the map


def spec() -> Spec:
    """Return the spec, from the description."""
    description = load("mercury")
    sand, air, motion = description["sand"], description["air"], description["motion"]
    limit = motion["limit_s"] + 3.0
    shortest, longest = air["burst_range_s"]
    burst = Argument("seconds", "s", shortest, longest, required=False)
    (x0, x1), (y0, y1) = sand["x"], sand["y"]
    place = Argument("x", "m", x0, x1, directions=ACROSS), Argument("y", "m", y0, y1, directions=ALONG)
    direction = Argument("dx", "", -1.0, 1.0, directions=ACROSS), Argument("dy", "", -1.0, 1.0, directions=ALONG)
    slowest, fastest = motion["speed_range"]
    speed = Argument("speed", "m/s", slowest, fastest)
    arm = description["arm"]
    scales = {
        name: Scale(radians(arm[f"{name}_deg"][0] - 1), radians(arm[f"{name}_deg"][1] + 1), 2e-5)
        for name in ("q1", "q2", "q4")
    }
    scales["q3"] = Scale(arm["q3"][0] - 0.002, arm["q3"][1] + 0.002, 2e-5)
    return Spec(
        name=description["name"],
        joints=("q1", "q2", "q3", "q4"),
        handover=("up", "home"),
        rest_s=motion["rest_s"],
        pose=Pose(("x", "y", "z", "theta"), packed=False),  # the console computes it from the joints
        scales=scales,
        capabilities=(
            Check(f"{HERE}.checks:check"),
            ClickInPicture("click", f"{HERE}.calibration:resolve"),
            Reset(),
            Excavation(
                "air", (x0, y0, x1, y1), f"{HERE}.pieces:pieces", "bury", once="burst", often="bursts", puzzle=PUZZLE
            ),
            PlanarArm(("q1", "q2"), (arm["link1"], arm["link2"])),
            FloorPlan(f"{HERE}.checks:floor_plan"),
            Calibration(f"{HERE}.calibration:calibrate", rows=MEASURED),
            stills(description["camera"], f"{HERE}.brightness:Brightness"),
            Setting("speed", "Speed", unit="m/s", low=slowest, high=fastest, default=motion["speed"]),
        ),
        commands=(
            CommandKind("move", "Move", place, limit_s=limit),
            CommandKind("up", "Up", limit_s=limit, says="Raise the camera"),
            CommandKind("down", "Down", limit_s=limit, says="Lower the nozzle to the sand"),
            CommandKind("air", "Air", (burst,), limit_s=6.0, says="Blow air[ for {seconds}]"),
            CommandKind("jog", "Small steps", direction, limit_s=JOG_LONGEST_S, held=True),
            CommandKind("home", "Home", limit_s=limit, asked_by=BY_STAFF),
            CommandKind("noop", "No operation", limit_s=5.0, moves=False, still_after=False),
            CommandKind(
                "speed",
                "Speed",
                (speed,),
                limit_s=5.0,
                asked_by=BY_STAFF,
                lane="config",
                moves=False,
                still_after=False,
            ),
            CommandKind(
                "bury",
                "Bury again",
                (Argument("number", "", 1, MOST_BEDS, whole=True),),
                limit_s=5.0,
                asked_by=frozenset(),
                lane="config",
                moves=False,
                still_after=False,
            ),
        ),
    )
