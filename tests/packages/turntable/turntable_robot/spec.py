from robots.contract.spec import Argument, CommandKind, Spec


def spec():
    return Spec(
        name="Turntable",
        joints=("table",),
        handover=("home",),
        commands=(CommandKind("turn", "Turn", (Argument("angle", "rad", -3.0, 3.0),)), CommandKind("home", "Home")),
    )
