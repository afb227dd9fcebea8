"""The byte streams of a robot, as its own functions read them."""

from robots.bus.streams import kept_stream
from robots.kit.contract.find import spec_of
from robots.kit.contract.streams import unpack
from robots.models import Robot


def packets_of(robot: Robot, stream: str) -> list[tuple[bytes, bool]]:
    """Return the packets since the stream's newest key packet, each with whether it is one; empty if none is known."""
    kept = kept_stream(robot.slug, [one.name for one in spec_of(robot.driver).streams].index(stream))
    return [(packet.data, packet.key) for packet in map(unpack, kept or ())]
