"""The floor on which a robot rolls, seen from above, for plots of its path. m; x to the right, y up."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import inf

MOST, FARTHEST = 500, 1e4  # things that are drawn; m from the origin
Box = tuple[float, float, float, float]


@dataclass(frozen=True)
class Floor:
    """The surroundings that a plot shows beside the path, in the frame of the robot's pose.

    `room`: its walls, and `rectangles`: what stands in it, each by two corners (x0, y0, x1, y1) with x0 < x1, y0 < y1;
    `circles`: by middle and radius (x, y, r). At most 500 together. Raises ValueError for anything else.
    """

    room: Box
    rectangles: tuple[Box, ...] = field(default=())
    circles: tuple[tuple[float, float, float], ...] = field(default=())

    def __post_init__(self) -> None:
        """Refuse a floor that cannot be drawn. Raises ValueError."""
        wrong = next(self._wrong(), "")
        if wrong:
            raise ValueError(f"{wrong} is no part of a floor.")

    def _wrong(self) -> Iterator[str]:
        rooms = (self.room, *self.rectangles)
        if len(rooms) + len(self.circles) > MOST:
            yield f"More than {MOST}"
        for x0, y0, x1, y1 in rooms:
            if not (-FARTHEST < x0 < x1 < FARTHEST and -FARTHEST < y0 < y1 < FARTHEST):
                yield f"The rectangle {x0:g}, {y0:g}, {x1:g}, {y1:g}"
        for x, y, radius in self.circles:
            if not (0 < radius < FARTHEST and max(abs(x), abs(y)) < FARTHEST < inf):
                yield f"The circle {x:g}, {y:g}, {radius:g}"
