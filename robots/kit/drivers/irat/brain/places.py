"""The place of the map that a goal means: one rule for the portal, at the click, and for the robot's own map."""

import math
from collections.abc import Iterable

import numpy as np

from robots.kit.contract.errors import BadRequest
from robots.kit.contract.session import JSON
from robots.kit.contract.values import number
from robots.kit.drivers.irat.brain.messages import NONE
from robots.kit.drivers.irat.composites.decoding import MapShown, with_map

CLICK_M = 0.1  # a click counts within this of a place
CLEARED = "The map was cleared, so this place is no longer known."
NO_PLACE = f"No place on the robot's map is within {CLICK_M:g} m of this click; choose one of its dots."
IN_DOCK = "This place is at the dock, where the robot goes only to charge; choose one farther away from it."


class MapCleared(BadRequest):
    """The goal's map is gone."""

    code = "map_cleared"


def goal_place(map_shown: MapShown, which: int, x: float, y: float, experience: int = NONE) -> int:
    """Return the id of the experience that a goal on map number `which` means: its own, else the nearest to x, y (m).

    Raises:
        MapCleared: the goal is on another map.
        BadRequest: the map has neither that experience nor one within `CLICK_M`, or only docking leads to it.

    """
    if which != map_shown.number:
        raise MapCleared(CLEARED)
    known = map_shown.where(np.array([experience], np.int64))
    if len(known):
        found, at = experience, known[0]
    else:
        apart = np.hypot(*(map_shown.places - (x, y)).T)
        if not len(apart) or not apart.min() <= CLICK_M:
            raise BadRequest(NO_PLACE)
        row = int(np.argmin(apart))
        found, at = int(map_shown.ids[row]), map_shown.places[row]
    if at_dock(map_shown, at[0], at[1]):
        raise BadRequest(IN_DOCK)
    return found


def at_dock(map_shown: MapShown, x: float, y: float) -> bool:
    """Return whether only docking leads to this place (m)."""
    return map_shown.dock is not None and math.dist((x, y), map_shown.dock[:2]) < map_shown.dock[2]


def check(kind: str, args: JSON, packets: Iterable[tuple[bytes, bool]]) -> None:
    """Refuse a goal by the map that the robot has shown; see `robots.kit.contract.capabilities.JobCheck`.

    Raises MapCleared, BadRequest. The robot judges again when it begins: its map grows, and may be cleared meanwhile.
    """
    if kind != "goal":
        return
    shown = shown_by(packets)
    if shown is None:
        return  # a map that cannot be read refuses nobody
    wanted = int(number(args, "experience")) if "experience" in args else NONE
    goal_place(shown, int(number(args, "map")), number(args, "x"), number(args, "y"), wanted)


def shown_by(packets: Iterable[tuple[bytes, bool]]) -> MapShown | None:
    """Return the map that these packets tell; None for one that cannot be read."""
    shown = MapShown()
    try:
        for data, key in packets:
            shown = with_map(shown, data, key)
    except ValueError:
        return None
    return shown
