"""`/statistics/`, `statistics.json` and `statistics.csv`: the daily figures of the portal, or of a robot."""

import codecs
import csv
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from typing import Any

from django.http import HttpRequest, HttpResponse, JsonResponse
from django.shortcuts import render
from django.utils.formats import number_format
from django.utils.http import urlencode
from django.utils.translation import gettext
from django.views.decorators.cache import never_cache
from django.views.decorators.http import require_safe

from operatorlog.services import excavation_of
from portal.edge.attempts import within as within_limit
from portal.web.daily import reading
from portal.web.daily.milestones import FIGURES, Day, Figure, Milestone, milestones, totals
from portal.web.daily.reading import A_DAY, SPANS, BadSpan, Selection, days_of, selection_of
from portal.web.statistics import plots
from portal.web.translation.english import in_english
from queueing.services import job_kinds
from robots.kit.clock import SYSTEM
from robots.models import Robot

FOR_A_MINUTE = {"Cache-Control": "public, max-age=60"}


class _Refused(Exception):
    def __init__(self, text: str, status: int) -> None:
        super().__init__(text)
        self.status = status


def _asked(request: HttpRequest, today: date) -> Selection:
    if not within_limit(request, "statistics"):
        raise _Refused(gettext("Your network asks for statistics too often; ask again in a minute."), 429)
    try:
        return selection_of(request.GET, today)
    except BadSpan as error:
        raise _Refused(str(error), 400) from error


@dataclass(frozen=True)
class Section:
    """One figure of the page: plot, the days with milestones in words, and the rows of its table, newest first."""

    figure: Figure
    plot: plots.Plot
    milestones: list[tuple[date, str]]
    rows: list[tuple[date, str]]
    known: bool


@never_cache
@require_safe
def statistics(request: HttpRequest) -> HttpResponse:
    """Show a plot of each figure with milestones, and the same as tables."""
    today = SYSTEM.now().date()
    try:
        asked = _asked(request, today)
    except _Refused as error:
        return render(request, "pages/daily.html", {"wrong": str(error), "spans": SPANS}, status=error.status)
    days = days_of(asked.robot)
    found, shown = milestones(days), reading.within(days, asked)
    left_out = ("finds",) if asked.robot is not None and excavation_of(asked.robot) is None else ()
    sections = [_section(figure, shown, found) for figure in FIGURES if figure.name not in left_out]
    context = {
        "asked": asked, "spans": SPANS, "robots": Robot.objects.filter(enabled=True, practice_for=None),
        "first": days[0] if days else None,
        "totals": [
            (one, number(one.value, one.whole)) for one in totals(days) if one.figure.name not in left_out
        ] if days else [],
        "sections": [one for one in sections if one.known], "unknown": [one for one in sections if not one.known],
        "milestones": found[::-1], "of_jobs": asked.robot is not None and bool(job_kinds(asked.robot)),
        "earlier": _address(asked, asked.since - A_DAY),
        "later": _address(asked, min(today, asked.until + asked.days * A_DAY)) if asked.until < today else "",
        "query": _address(asked, asked.until),
    }  # fmt: skip
    return render(request, "pages/daily.html", context)


def _address(asked: Selection, until: date) -> str:
    named = [("robot", asked.robot.slug)] if asked.robot else []
    return "?" + urlencode([*named, ("days", str(asked.days)), ("until", until.isoformat())])


def _section(figure: Figure, days: Sequence[Day], found: Sequence[Milestone]) -> Section:
    values = [one.values.get(figure.name) for one in days]
    shown = [None if value is None else figure.in_unit(value) for value in values]
    reached: dict[date, list[str]] = {}
    for one in found:
        if one.figure == figure.name and days[0].day <= one.day <= days[-1].day:
            reached.setdefault(one.day, []).append(one.text)
    whole = [day.whole or figure.name != "addresses" for day in days]
    texts = [number(value, sure) for value, sure in zip(shown, whole, strict=True)]
    plot = plots.days([(one.day, value, text) for one, value, text in zip(days, shown, texts, strict=True)],
                      reached)  # fmt: skip
    rows = [(one.day, text) for one, text in zip(days, texts, strict=True)][::-1]
    marked = [(day, "; ".join(said)) for day, said in reached.items()]
    return Section(figure, plot, marked, rows, any(value is not None for value in shown))


def number(value: float | None, whole: bool = True) -> str:
    """Return a figure in words; one that is not whole is a lower bound."""
    if value is None:
        return gettext("not known")
    digits = 0 if value >= 100 or value == int(value) else 2
    text = str(number_format(f"{value:.{digits}f}", digits, force_grouping=True))
    return text if whole else gettext("at least {number}").format(number=text)


@require_safe
@in_english
def statistics_json(request: HttpRequest) -> JsonResponse:
    """Return the same for programs; null is what is not known. Shared caches keep it, but never a refusal."""
    try:
        asked = _asked(request, SYSTEM.now().date())
    except _Refused as error:
        return JsonResponse({"error": str(error)}, status=error.status, headers={"Cache-Control": "no-store"})
    days = days_of(asked.robot)
    told = {
        "robot": asked.robot.slug if asked.robot else None,
        "since": asked.since, "until": asked.until,
        "days": [_told(one) for one in reading.within(days, asked)],
        "milestones": [
            {"day": one.day, "figure": one.figure, "number": one.number, "text": one.text} for one in milestones(days)
        ],
        "totals": {
            one.figure.name: {"value": one.value * one.figure.size, "complete": one.whole} for one in totals(days)
        },
    }  # fmt: skip
    return JsonResponse(told, headers=FOR_A_MINUTE)


def _told(day: Day) -> dict[str, Any]:
    return {"day": day.day, **{name: day.values.get(name) for name in reading.NAMES}, "addresses_complete": day.whole}


@require_safe
@in_english
def statistics_csv(request: HttpRequest) -> HttpResponse:
    """Return the days as CSV; an empty field is what is not known."""
    try:
        asked = _asked(request, SYSTEM.now().date())
    except _Refused as error:
        text = f"{error}\n"
        return HttpResponse(text, status=error.status, content_type="text/plain", headers={"Cache-Control": "no-store"})
    name = asked.robot.slug if asked.robot else "portal"
    rows = [_told(one) for one in reading.within(days_of(asked.robot), asked)]
    answer = HttpResponse(codecs.BOM_UTF8, content_type="text/csv; charset=utf-8", headers=FOR_A_MINUTE)
    answer["Content-Disposition"] = f'attachment; filename="farhand-{name}-{asked.until}.csv"'
    writer = csv.DictWriter(answer, list(rows[0]))
    writer.writeheader()
    writer.writerows(rows)
    return answer
