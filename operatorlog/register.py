"""The page of finds: pieces that were found, a map of what was dug, rounds that are over.

Nothing here reads where a piece that nobody has found is hidden, nor its name: a place on the page is that of a find.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, log2
from typing import Any

from django.core.cache import cache
from django.db.models import Count, Exists, F, FloatField, OuterRef, QuerySet
from django.db.models.fields.json import KeyTextTransform, KeyTransform
from django.db.models.functions import Cast, Floor
from django.utils.translation import gettext, pgettext, pgettext_lazy

from operatorlog.finds import excavation_of, present_round
from operatorlog.models import Entry, Find, Piece, Round, Visibility
from robots.kit.contract.excavation import Excavation
from robots.kit.contract.find import function
from robots.kit.contract.words import quantity
from robots.models import Command, Frame, Robot
from robots.sentences import translate
from robots.states import CommandState

WIDTH, MARGIN = 640.0, 16.0  # px of the map
MOST_FINDS, MOST_ROUNDS = 500, 20
STORED_S = 3600  # what was counted, until something is dug again
LEVELS = 5
NUMBERS = [
    pgettext_lazy("number", "no"), pgettext_lazy("number", "one"), pgettext_lazy("number", "two"),
    pgettext_lazy("number", "three"), pgettext_lazy("number", "four"), pgettext_lazy("number", "five"),
    pgettext_lazy("number", "six"), pgettext_lazy("number", "seven"), pgettext_lazy("number", "eight"),
    pgettext_lazy("number", "nine"), pgettext_lazy("number", "ten"), pgettext_lazy("number", "eleven"),
    pgettext_lazy("number", "twelve"),
]  # fmt: skip


@dataclass(frozen=True)
class FoundPiece:
    """A piece that was found: by whom first, where (m) that find is, and on the map (px, y down)."""

    number: int
    find: Find
    frame: Frame | None
    more: int
    x: float
    y: float

    @property
    def where(self) -> tuple[str, str]:
        """Return its place in the robot's coordinates, x and y."""
        return place_said(self.find)


@dataclass(frozen=True)
class Cell:
    """A square of the map in which something was dug: its corner and size (px), how often, and the words for it."""

    x: float
    y: float
    size: float
    count: int
    level: int
    words: str
    where: str


@dataclass(frozen=True)
class Milestone:
    """A round: what was found of how many pieces."""

    round: Round
    found_pieces: tuple[FoundPiece, ...]
    pieces: int


@dataclass(frozen=True)
class Register:
    """All that the page shows. `pieces`: how many are hidden in the present round, found ones included."""

    present: Round | None
    found_pieces: tuple[FoundPiece, ...]
    pieces: int
    cells: tuple[Cell, ...]
    earlier: tuple[Milestone, ...]
    width: float
    height: float
    digs: int
    often: str

    @property
    def hidden(self) -> int:
        """Return how many pieces nobody has found yet."""
        return max(0, self.pieces - len(self.found_pieces))


def register_of(robot: Robot) -> Register | None:
    """Return the register of finds of a robot; None for one without hidden pieces."""
    declared = excavation_of(robot)
    if declared is None:
        return None
    present = present_round(robot)
    rounds = list(Round.objects.filter(robot=robot, ended_at__isnull=False).order_by("-number")[:MOST_ROUNDS])
    shown = [*([present] if present else []), *rounds]
    of_round = _finds(shown, declared)
    totals = dict(Piece.objects.filter(round__in=shown).values_list("round").annotate(Count("pk")).order_by())
    pieces = totals.get(present.pk, 0) if present else _first_pieces(robot, declared)
    cells = _cells(robot, declared, present)
    _, y0, _, y1 = declared.area
    return Register(
        present, of_round.get(present.pk, ()) if present else (), pieces, cells,
        tuple(Milestone(one, of_round.get(one.pk, ()), totals.get(one.pk, 0)) for one in rounds),
        WIDTH, round(2 * MARGIN + (y1 - y0) * _scale(declared)), sum(cell.count for cell in cells),
        translate(declared.often),
    )  # fmt: skip


def newest_find() -> Find | None:
    """Return the confirmed find that was seen last, of a robot of the catalogue; its picture is one for everybody."""
    secret = Entry.objects.filter(turn=OuterRef("turn"), visibility=Visibility.HIDDEN)
    rows = Find.objects.filter(~Exists(secret), state=Find.State.CONFIRMED, piece__isnull=False, frame__isnull=False)
    rows = rows.filter(round__robot__enabled=True).order_by("-seen_at", "-id")
    return rows.select_related("piece", "author", "frame__robot", "turn", "round__robot").first()


def place_said(find: Find) -> tuple[str, str]:
    """Return the place of a find in the robot's coordinates, x and y."""
    return f"x {quantity(find.x, 'm')}", f"y {quantity(find.y, 'm')}"


def _first_pieces(robot: Robot, declared: Excavation) -> int:
    """Return how many pieces a simulated bed has before its first round is stored."""
    return len(function(declared.pieces)("", 1)) if declared.pieces and robot.simulated else 0


def _scale(declared: Excavation) -> float:
    x0, _, x1, _ = declared.area
    return (WIDTH - 2 * MARGIN) / (x1 - x0)  # px a m


def _at(declared: Excavation, x: float, y: float) -> tuple[float, float]:
    x0, _, _, y1 = declared.area
    return round(MARGIN + (x - x0) * _scale(declared), 1), round(MARGIN + (y1 - y) * _scale(declared), 1)


def _finds(rounds: Sequence[Round], declared: Excavation) -> dict[int, tuple[FoundPiece, ...]]:
    """Return the found pieces of each round, in the order in which they were found first."""
    secret = Entry.objects.filter(turn=OuterRef("turn"), visibility=Visibility.HIDDEN)
    rows = Find.objects.filter(round__in=rounds, state=Find.State.CONFIRMED, piece__isnull=False)
    rows = rows.select_related("piece", "author", "frame__robot", "turn").annotate(secret=Exists(secret))
    of_piece: dict[tuple[int, Any], list[Find]] = {}
    for find in rows.order_by("seen_at", "id")[:MOST_FINDS]:
        of_piece.setdefault((find.round_id, find.piece_id), []).append(find)
    found: dict[int, list[FoundPiece]] = {}
    for (of_round, _), finds in of_piece.items():
        first, here = finds[0], found.setdefault(of_round, [])
        frame = None if first.secret else first.frame  # type: ignore[attr-defined]
        here.append(FoundPiece(len(here) + 1, first, frame, len(finds) - 1, *_at(declared, first.x, first.y)))
    return {of_round: tuple(all_of_it) for of_round, all_of_it in found.items()}


def dug_map(robot: Robot) -> dict[str, Any] | None:
    """Return what a console's map shows of the present round; None for a robot without hidden pieces.

    `area` (x, y of two corners, m) has squares of `cell_m`; `cells` are column, row and how often it was dug, up to
    the command `newest`. `words` says one to twelve times, `more` any other number. `found`: number, name, x, y (m).
    """
    declared = excavation_of(robot)
    if declared is None:
        return None
    present = present_round(robot)
    newest, counts = _counts(robot, declared, present)
    found = _finds([present], declared).get(present.pk, ()) if present else ()
    return {
        "area": declared.area, "cell_m": declared.cell_m, "newest": newest, "cells": counts,
        "words": [digs_said(declared, count) for count in range(1, len(NUMBERS))],
        "more": digs_said(declared, "{number}"),
        "found": [
            [one.number, pgettext("piece", one.find.piece.name), one.find.x, one.find.y]
            for one in found
            if one.find.piece
        ],
    }  # fmt: skip


def _cells(robot: Robot, declared: Excavation, present: Round | None) -> tuple[Cell, ...]:
    _, counts = _counts(robot, declared, present)
    size = round(declared.cell_m * _scale(declared), 1)
    return tuple(_cell(declared, column, row, size, count) for column, row, count in counts)


def _counts(robot: Robot, declared: Excavation, present: Round | None) -> tuple[int, list[list[int]]]:
    """Return the newest command that dug, 0 for none, and what was dug; it is counted once until one digs again."""
    done = Command.objects.filter(robot=robot, kind=declared.kind, state=CommandState.COMPLETED)
    done = done.filter(ended_at__gte=present.began_at) if present else done.filter(ended_at__isnull=False)
    newest = done.order_by("-ended_at", "-id").values_list("pk", flat=True).first() or 0
    name = f"dug-2:{robot.pk}:{present.pk if present else 0}:{newest}"
    return newest, cache.get_or_set(name, lambda: _dug(done, declared), STORED_S) or []


def _dug(done: QuerySet[Command], declared: Excavation) -> list[list[int]]:
    """Return column, row and how often it was dug of each square, in one query with at most a row a square."""
    x0, y0, x1, y1 = declared.area
    done = done.filter(result__sent__has_keys=["x", "y"]).order_by()
    done = done.exclude(result__sent__x=None).exclude(result__sent__y=None)  # a place that was not finite
    sent = {name: Cast(KeyTextTransform(name, KeyTransform("sent", "result")), FloatField()) for name in ("x", "y")}
    placed = done.annotate(at_x=sent["x"], at_y=sent["y"]).filter(
        at_x__gte=x0, at_x__lte=x1, at_y__gte=y0, at_y__lte=y1
    )
    squares = placed.annotate(
        column=Floor((F("at_x") - x0) / declared.cell_m), row=Floor((F("at_y") - y0) / declared.cell_m)
    )
    columns, rows = ceil((x1 - x0) / declared.cell_m), ceil((y1 - y0) / declared.cell_m)
    counted: dict[tuple[int, int], int] = {}
    for column, row, count in squares.values_list("column", "row").annotate(count=Count("pk")):
        square = min(int(column), columns - 1), min(int(row), rows - 1)  # the last edge belongs to the last square
        counted[square] = counted.get(square, 0) + count
    return [[*square, count] for square, count in sorted(counted.items())]


def _cell(declared: Excavation, column: int, row: int, size: float, count: int) -> Cell:
    x0, y0, _, _ = declared.area
    left, low = x0 + column * declared.cell_m, y0 + row * declared.cell_m
    x, y = _at(declared, left, low + declared.cell_m)
    level = min(LEVELS, 1 + int(log2(count)))
    return Cell(x, y, size, count, level, digs_said(declared, count), _square(declared, left, low))


def _square(declared: Excavation, left: float, low: float) -> str:
    right, high = left + declared.cell_m, low + declared.cell_m
    ends = {"left": left, "right": right, "low": low, "high": high}
    said = gettext("x {left} to {right} cm, y {low} to {high} cm")
    return said.format(**{name: f"{100 * value:.0f}" for name, value in ends.items()})


def digs_said(declared: Excavation, count: int | str) -> str:
    """Return how often something was dug, as "about five bursts here"; a text stands as it is."""
    if count == 1:
        return gettext("one {burst} here").format(burst=translate(declared.once))
    number = NUMBERS[count] if isinstance(count, int) and count < len(NUMBERS) else count
    return gettext("about {number} {bursts} here").format(number=number, bursts=translate(declared.often))
