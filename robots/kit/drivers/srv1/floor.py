"""The hall as plots of the rover's path show it."""

from robots.kit.contract.floor import Floor
from robots.kit.contract.session import JSON
from robots.kit.drivers.srv1.hall import hall


def plan(_settings: JSON) -> Floor:
    """Return walls, showcases and exhibits."""
    place = hall()
    boxes = ((c.at[0] - c.half[0], c.at[1] - c.half[1], c.at[0] + c.half[0], c.at[1] + c.half[1]) for c in place.cases)
    rounds = ((e.at[0], e.at[1], e.radius) for e in place.exhibits)
    return Floor((0.0, 0.0, place.width, place.depth), tuple(boxes), tuple(rounds))
