from robots.contract.spec import Argument, CommandKind, Spec


def spec():
    pace = Argument("pace", "rad/s", 0.1, 2.0)
    return Spec(
        name="Turntable",
        joints=("table",),
        handover=("home",),
        commands=(
            CommandKind("turn", "Turn", (Argument("angle", "rad", -3.0, 3.0),)),
            CommandKind("home", "Home"),
            CommandKind("pace", "Pace", (pace,), lane="config", default={"pace": 1.0}, moves=False, still_after=False),
        ),
    )
