"""The spec of the Mercury arm; readable without its driver."""

from math import radians

from robots.contract.capabilities import Calibration, Check, ClickInPicture, Reset, Stills
from robots.contract.channels import Pose, Scale
from robots.contract.spec import STAFF, Argument, CommandKind, Spec
from robots.description import load

JOG_LONGEST_S = 20.0
HERE = "robots.drivers.mercury"
BY_STAFF = frozenset({STAFF})


def spec() -> Spec:
    """Return the spec, from the description."""
    description = load("mercury")
    sand, air, motion = description["sand"], description["air"], description["motion"]
    limit = motion["limit_s"] + 3.0
    shortest, longest = air["burst_range_s"]
    burst = Argument("seconds", "s", shortest, longest, required=False)
    place = Argument("x", "m", *sand["x"]), Argument("y", "m", *sand["y"])
    direction = Argument("dx", "", -1.0, 1.0), Argument("dy", "", -1.0, 1.0)
    speed = Argument("speed", "m/s", *motion["speed_range"])
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
            ClickInPicture("click", f"{HERE}.click:resolve"),
            Reset(),
            Calibration(f"{HERE}.calibrating:calibrate"),
            Stills.described(description["camera"], f"{HERE}.brightness:Brightness"),
        ),
        commands=(
            CommandKind("move", "Move", place, limit_s=limit),
            CommandKind("up", "Up", limit_s=limit),
            CommandKind("down", "Down", limit_s=limit),
            CommandKind("air", "Air", (burst,), limit_s=6.0),
            CommandKind("jog", "Jog", direction, limit_s=JOG_LONGEST_S, held=True),
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
        ),
    )
