"""The places of its map to which people may send the robot, in words, for forms without scripts."""

import math
from collections.abc import Iterable

from robots.kit.drivers.irat.brain.places import at_dock, shown_by
from robots.kit.drivers.irat.composites.decoding import Places

APART_M, MOST = 0.42, 26  # between two of them, as on the console; so many


def choices(packets: Iterable[tuple[bytes, bool]]) -> list[tuple[str, dict[str, float]]]:
    """Return well-spread places of the map that the robot has shown, in words; see `JobChoices`."""
    shown = shown_by(packets)
    if shown is None or not len(shown.ids):
        return []
    low, high = shown.places.min(axis=0), shown.places.max(axis=0)
    found: list[tuple[int, float, float]] = []
    for number, (x, y) in zip(shown.ids.tolist(), shown.places.tolist(), strict=True):
        apart = all(math.dist((x, y), (i, k)) >= APART_M for _, i, k in found)
        if apart and len(found) < MOST and not at_dock(shown, x, y):
            found.append((number, x, y))
    found.sort(key=lambda one: (-_third(one[2], low[1], high[1]), _third(one[1], low[0], high[0]), -one[2]))
    return [
        (
            f"{_whereabouts((x, y), low, high)} ({x - low[0]:.1f} m from the left, {y - low[1]:.1f} m from the bottom)",
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
