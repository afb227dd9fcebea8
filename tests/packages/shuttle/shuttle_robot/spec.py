"""A cart on a rail that takes goals from everybody, drives about by itself, and needs its dock."""

from robots.kit.contract.capabilities import GoodWhile, Idle, Need, Share, Statistics, Times, Total
from robots.kit.contract.channels import Pose, Scalar
from robots.kit.contract.spec import ANYONE, STAFF, Argument, CommandKind, Spec

RAILS = 1000.0  # people count their rails
PLACE = (Argument("x", "m", 0.0, 2.0), Argument("rail", "", 1.0, RAILS, required=False, whole=True))


def spec():
    return Spec(
        name="Shuttle",
        joints=("cart",),
        pose=Pose(("x",)),
        channels=(Scalar("battery", "", 0.0, 1.0), Scalar("driven", "m", 0.0, 1e6), Scalar("rail", "", 1.0, RAILS)),
        commands=(
            CommandKind("go", "Drive to", PLACE, asked_by=frozenset({ANYONE}), limit_s=20.0),
            CommandKind("roam", "Roam", asked_by=frozenset({STAFF})),
            CommandKind("dock", "Dock", asked_by=frozenset({STAFF}), limit_s=30.0),
        ),
        capabilities=(
            Idle("roam", 60.0),
            Need("dock", "battery", 0.3, 0.9),
            GoodWhile("go", "rail", "rail", "rail", "The rail was taken away, so this place is no longer there."),
            Statistics(
                rows=(
                    Total("Driven", "driven"),
                    Times("Recharges", "dock"),
                    Times("Recharges that failed", "dock", failed=True),
                    Share("Time on the rail", ("go", "roam")),
                ),
                ends=(("rail", "Dropped, because the rail was taken away"),),
                against="battery",
                over_time="battery",
                job="trip",
                done="arrived",
            ),
        ),
    )
