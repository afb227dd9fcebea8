from robots.kit.contract.capabilities import Idle
from robots.kit.contract.channels import Scalar
from robots.kit.contract.policies import Bound, Policies, Range
from robots.kit.contract.spec import ANYONE, STAFF, TURN, Argument, CommandKind, Spec
from robots.kit.contract.streams import Stream

EVERYBODY = frozenset({TURN, ANYONE})
WHERE = (Range("table", -3.1, 3.1),)
ALONE = Policies(on_link_lost=Bound(5.0, WHERE), on_grant_end=Bound(2.0, WHERE))


def spec():
    pace = Argument("pace", "rad/s", 0.1, 2.0)
    return Spec(
        name="Turntable",
        joints=("table",),
        handover=("home",),
        channels=(Scalar("warmth", "°C", 0.0, 90.0), Scalar("pace", "rad/s", 0.0, 2.0)),
        streams=(Stream("trail"),),
        commands=(
            CommandKind("turn", "Turn", (Argument("angle", "rad", -3.0, 3.0),), shown={"angle": "table"}),
            CommandKind("home", "Home"),
            CommandKind("fling", "Fling", level=2),
            CommandKind(
                "tour", "Tour", (Argument("stops", "", 1, 8, whole=True),), asked_by=EVERYBODY, limit_s=60.0, policies=ALONE
            ),
            CommandKind("sway", "Sway", asked_by=frozenset({STAFF}), limit_s=60.0),
            CommandKind(
                "pace", "Pace", (pace,), lane="config", default={"pace": 1.0}, shown={"pace": "pace"},
                moves=False, still_after=False,
            ),
        ),
        capabilities=(Idle("sway", 60.0),),
    )  # fmt: skip
