"""What the SO-101 can do; readable without LeRobot."""

from robots.contract.spec import Spec
from robots.drivers.lerobot_spec import spec_from


def spec() -> Spec:
    """Return what the arm can do, from its description."""
    return spec_from("so101")
