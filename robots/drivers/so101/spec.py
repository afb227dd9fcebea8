"""The spec of the SO-101; readable without LeRobot."""

from robots.contract.spec import Spec
from robots.drivers.lerobot_spec import spec_from


def spec() -> Spec:
    """Return the spec, from the description."""
    return spec_from("so101")
