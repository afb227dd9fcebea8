"""An arm whose links turn in one horizontal plane, seen from above: where its base, its joints and its tool are."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from math import cos, sin


@dataclass(frozen=True)
class PlanarArm:
    """The robot is an arm of links in a horizontal plane, as a SCARA; movies draw it from above, over its `FloorPlan`.

    `joints` names, from the base on, those of the spec that turn a link (rad), each against the link before it, the
    first against the x axis. `links` has the length of each link (m). The base stands at 0, 0. Raises ValueError for
    another number of links than of joints.
    """

    joints: tuple[str, ...]
    links: tuple[float, ...]

    def __post_init__(self) -> None:
        """Refuse an arm that cannot be drawn. Raises ValueError."""
        if not self.joints or len(self.joints) != len(self.links):
            raise ValueError("A planar arm has one link for each joint.")

    def places(self, angles: Sequence[float]) -> tuple[tuple[float, float], ...]:
        """Return the base, each joint after the first, and the tool (m), for the angles of its joints (rad)."""
        found = [(0.0, 0.0)]
        for length, direction in zip(self.links, accumulate(angles), strict=True):
            x, y = found[-1]
            found.append((x + length * cos(direction), y + length * sin(direction)))
        return tuple(found)
