"""The path that a robot drove, over the path planned, as a drawing of a job's page: from above, one for each run.

It is drawn from the track that was read from the recording when its movie was made; without one, from the places at
which the robot noted something. Both are bounded.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import dist
from typing import Any

from django.utils.translation import gettext

from robots.kit.contract.floor import Box, Floor
from robots.kit.recording.floors import floor_of
from robots.kit.recording.paths import IN_PLANE, POINTS, Line, Place, is_place, plot_bounds
from robots.models import Finding, Recording, Robot

WIDTH, MARGIN = 640.0, 12.0  # px of the drawing
TALLEST = 900.0  # px: a path that is longer than wide is drawn smaller
LEAST_M = 0.05  # a shorter path is not drawn
ACROSS, IN_A_ROW = 28.0, 5  # width of a mark (px); marks of one place in a row
SAID = 12  # places that the words name


@dataclass(frozen=True)
class Figure:
    """A drawing in px, y down, and the words that say the same.

    `joined`: the lines driven are straight ones between the places at which it noted something.
    `room` and `rectangles` are x, y, width and height, `circles` x, y and radius; lines are points as SVG writes them;
    `marks` are the pictures' numbers in the table of findings, with x and y.
    """

    width: float
    height: float
    room: Box | None
    rectangles: tuple[Box, ...]
    circles: tuple[tuple[float, float, float], ...]
    planned: tuple[str, ...]
    driven: tuple[str, ...]
    marks: tuple[tuple[int, float, float], ...]
    begin: Place
    end: Place
    words: str
    joined: bool


def figures_of(robot: Robot, findings: Sequence[Finding], recordings: Iterable[Recording]) -> list[Figure]:
    """Return a figure for each run of which a path is known; none of a robot that does not roll in the plane."""
    try:
        if robot.spec().carried() != IN_PLANE:
            return []
    except LookupError:  # its package is gone
        return []
    tracks = {one.grant_id: one.track for one in recordings if one.track}
    found: dict[int, list[Finding]] = {grant: [] for grant in tracks}
    for one in findings:
        found.setdefault(one.command.grant_id, []).append(one)
    drawn = [_run(tracks.get(grant, {}), found[grant]) for grant in sorted(found)]
    known = [run for run in drawn if length(run.driven) >= LEAST_M]
    floor = floor_of(robot.driver, robot.driver_settings()) if known else None
    return [figure(floor, run) for run in known]


@dataclass(frozen=True)
class Run:
    """The path of one run (m), and the places of its pictures. `joined`: `driven` joins the places that were noted."""

    driven: list[Line]
    plan: list[Line]
    pictures: list[tuple[int, Place]]
    joined: bool = False


def _run(track: Mapping[str, Any], findings: Sequence[Finding]) -> Run:
    noted = [one for one in findings if len(one.pose) == len(IN_PLANE) and is_place(one.pose)]
    places = {one.number: (float(one.pose[0]), float(one.pose[1])) for one in noted}
    pictures = [(one.number, places[one.number]) for one in noted if one.frame_id is not None]
    driven, planned = _lines(track.get("driven")), _lines(track.get("planned"))
    return Run(driven or [list(places.values())], planned, pictures, not driven)


def _lines(told: Any) -> list[Line]:
    """Return the lines of a stored track; anything else in it is left out."""
    lines = [[(float(x), float(y)) for x, y in line if is_place((x, y))] for line in told or ()]
    return [line[:POINTS] for line in lines[:POINTS] if line]


def figure(floor: Floor | None, run: Run) -> Figure:
    """Return the drawing of a run."""
    box = plot_bounds(floor, [*run.driven, *run.plan, [place for _, place in run.pictures]])
    wide, tall = box[2] - box[0], box[3] - box[1]
    scale = min((WIDTH - 2 * MARGIN) / wide, (TALLEST - 2 * MARGIN) / tall)  # px a m

    def at(place: Place) -> Place:
        return round(MARGIN + scale * (place[0] - box[0]), 1), round(MARGIN + scale * (box[3] - place[1]), 1)

    def rectangle(corners: Box) -> Box:
        x, y = at((corners[0], corners[3]))
        return x, y, round(scale * (corners[2] - corners[0]), 1), round(scale * (corners[3] - corners[1]), 1)

    def points(lines: Sequence[Line]) -> tuple[str, ...]:
        return tuple(" ".join(f"{x:g},{y:g}" for x, y in map(at, line)) for line in lines)

    return Figure(
        round(2 * MARGIN + scale * wide), round(2 * MARGIN + scale * tall), rectangle(floor.room) if floor else None,
        tuple(map(rectangle, floor.rectangles)) if floor else (),
        tuple((*at((x, y)), round(scale * r, 1)) for x, y, r in floor.circles) if floor else (),
        points(run.plan), points(run.driven), beside([(number, *at(place)) for number, place in run.pictures]),
        at(run.driven[0][0]), at(run.driven[-1][-1]), words_of(run), run.joined,
    )  # fmt: skip


def beside(marks: Iterable[tuple[int, float, float]]) -> tuple[tuple[int, float, float], ...]:
    """Return marks of which none covers another: those of one place stand in a row, up to `IN_A_ROW`, to the inside."""
    placed: list[tuple[int, float, float]] = []
    for number, x, y in marks:
        step = ACROSS if x < WIDTH / 2 else -ACROSS
        spots = [(x + step * n, y) for n in range(IN_A_ROW)]
        free = (spot for spot in spots if all(dist(spot, (a, b)) >= ACROSS for _, a, b in placed))
        placed.append((number, *next(free, (x, y))))
    return tuple(placed)


def length(lines: Sequence[Line]) -> float:
    """Return the length of a path (m)."""
    return sum(dist(a, b) for line in lines for a, b in pairwise(line))


def words_of(run: Run) -> str:
    """Return a figure in words."""
    begin, end = run.driven[0][0], run.driven[-1][-1]
    if run.joined:
        way = gettext(
            "In straight lines between the places at which it noted something: {length} m, from {begin} to {end}."
        )
    else:
        way = gettext("It drove {length} m, from {begin} to {end}.")
    said = [way.format(length=f"{length(run.driven):.1f}", begin=_m(begin), end=_m(end))]
    if run.plan:
        planned = gettext("Planned were {length} m; it ended {away} m from where the plan ends.")
        away = dist(end, run.plan[-1][-1])
        said.append(planned.format(length=f"{length(run.plan):.1f}", away=f"{away:.1f}"))
    if run.pictures:
        at = gettext("{number} at {place}")
        places = ", ".join(at.format(number=number, place=_m(place)) for number, place in run.pictures[:SAID])
        more = len(run.pictures) - SAID
        form = (
            gettext("Pictures: {places}, and {more} more (x, y in m).")
            if more > 0
            else gettext("Pictures: {places} (x, y in m).")
        )
        said.append(form.format(places=places, more=more))
    return " ".join(said)


def _m(place: Place) -> str:
    return f"({place[0]:.1f}, {place[1]:.1f})"
