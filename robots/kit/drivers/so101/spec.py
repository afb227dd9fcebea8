"""The spec of the SO-101; readable without LeRobot."""

from robots.kit.contract.spec import Spec
from robots.kit.drivers.lerobot_spec import spec_from


def spec() -> Spec:
    """Return the spec, from the description."""
    return spec_from("so101")
