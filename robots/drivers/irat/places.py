"""Which place of the map a goal means: one rule for the portal, at the click, and for the robot's own map."""

import math
from collections.abc import Iterable

import numpy as np

from robots.contract.session import JSON
from robots.contract.values import number
from robots.drivers.errors import BadRequest
from robots.drivers.irat.brain.messages import NONE
from robots.drivers.irat.composites.decoding import MapShown, Places, with_map

APART_M, MOST_CHOICES = 0.42, 26  # between two places of the list, as on the console
CLICK_M = 0.1  # a click counts within this of a place
CLEARED = "The map was cleared, so this place is no longer known."
NO_PLACE = f"No place on the robot's map is within {CLICK_M:g} m of this click; choose one of its dots."
IN_DOCK = "This place is at the dock, where the robot goes only to charge; choose one farther away from it."


class MapCleared(BadRequest):
    """The goal's map is gone."""

    code = "map_cleared"


def chosen(shown: MapShown, which: int, x: float, y: float, experience: int = NONE) -> int:
    """Return the id of the experience that a goal on map number `which` means: its own, else the nearest to x, y (m).

    Raises:
        MapCleared: the goal is on another map.
        BadRequest: the map has neither that experience nor one within `CLICK_M`, or only docking leads to it.

    """
    if which != shown.number:
        raise MapCleared(CLEARED)
    known = shown.where(np.array([experience], np.int64))
    if len(known):
        found, at = experience, known[0]
    else:
        apart = np.hypot(*(shown.places - (x, y)).T)
        if not len(apart) or not apart.min() <= CLICK_M:
            raise BadRequest(NO_PLACE)
        row = int(np.argmin(apart))
        found, at = int(shown.ids[row]), shown.places[row]
    if shown.dock is not None and math.dist(at, shown.dock[:2]) < shown.dock[2]:
        raise BadRequest(IN_DOCK)
    return found


def choices(packets: Iterable[tuple[bytes, bool]]) -> list[tuple[str, dict[str, float]]]:
    """Return well-spread places of the map that the robot has shown, in words; see `JobChoices`."""
    shown = _shown(packets)
    if shown is None or not len(shown.ids):
        return []
    low, high = shown.places.min(axis=0), shown.places.max(axis=0)
    found: list[tuple[int, float, float]] = []
    for number, (x, y) in zip(shown.ids.tolist(), shown.places.tolist(), strict=True):
        at_dock = shown.dock is not None and math.dist((x, y), shown.dock[:2]) < shown.dock[2]
        if not at_dock and all(math.dist((x, y), (i, k)) >= APART_M for _, i, k in found) and len(found) < MOST_CHOICES:
            found.append((number, x, y))
    found.sort(key=lambda one: (-_third(one[2], low[1], high[1]), _third(one[1], low[0], high[0]), -one[2]))
    return [
        (
            f"{_whereabouts((x, y), low, high)} ({x:.1f} m right, {y:.1f} m up)",
            {"map": shown.number, "x": round(x, 3), "y": round(y, 3), "experience": number},
        )
        for number, x, y in found
    ]


def _third(value: float, low: float, high: float) -> int:
    return min(2, int(3 * (value - low) / max(high - low, 0.1)))


def _whereabouts(at: tuple[float, float], low: Places, high: Places) -> str:
    """Return where a place is on the map as it is drawn."""
    row = ("Bottom", "", "Top")[_third(at[1], low[1], high[1])]
    column = ("left", "", "right")[_third(at[0], low[0], high[0])]
    return f"{row} {column}".strip().capitalize() or "Centre"


def check(kind: str, args: JSON, packets: Iterable[tuple[bytes, bool]]) -> None:
    """Refuse a goal by the map that the robot has shown; see `robots.contract.capabilities.JobCheck`.

    Raises MapCleared, BadRequest. The robot judges again when it begins: its map grows, and may be cleared meanwhile.
    """
    if kind != "goal":
        return
    shown = _shown(packets)
    if shown is None:
        return  # a map that cannot be read refuses nobody
    wanted = int(number(args, "experience")) if "experience" in args else NONE
    chosen(shown, int(number(args, "map")), number(args, "x"), number(args, "y"), wanted)


def _shown(packets: Iterable[tuple[bytes, bool]]) -> MapShown | None:
    shown = MapShown()
    try:
        for data, key in packets:
            shown = with_map(shown, data, key)
    except ValueError:
        return None
    return shown
