"""The results of the survey for staff: plots, and all answers as CSV."""

import codecs
import csv
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from django.contrib.auth.decorators import permission_required
from django.http import HttpRequest, HttpResponse
from django.shortcuts import render
from django.utils.formats import localize
from django.utils.translation import gettext, ngettext
from django.views.decorators.cache import never_cache

from operatorlog.models import SurveyQuestion, SurveyResponse
from robots.kit.clock import SYSTEM

NEWEST = 100  # texts
FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n", "＝", "＋", "－", "＠")  # some spreadsheets execute such text
SCALE = SurveyQuestion.Kind.SCALE


def answers_in_words(count: int) -> str:
    """Return a number of answers as text."""
    return ngettext("%d answer", "%d answers", count) % count


@never_cache
@permission_required("operatorlog.view_surveyresponse", raise_exception=True)
def results(request: HttpRequest) -> HttpResponse:
    """Show the answers to staff."""
    shown = [{"prompt": q.prompt, "plots": plots(q)} for q in SurveyQuestion.objects.all()]
    return render(request, "operatorlog/results.html", {"questions": shown, "total": SurveyResponse.objects.count()})


def plots(question: SurveyQuestion) -> list[dict[str, Any]]:
    """Return the plots of a question: first of its answers, then of those that it got while it had another kind."""
    values: dict[str, list[str]] = defaultdict(list)
    for kind, value in question.answers.order_by("id").values_list("kind", "value"):
        values[kind or question.kind].append(value)
    now = {"before": "", **_plot(question.kind, values.pop(question.kind, []), question.choices())}
    labels = dict(SurveyQuestion.Kind.choices)
    return [now, *({"before": labels[kind], **_plot(kind, values[kind], [])} for kind in sorted(values))]


def _plot(kind: str, values: list[str], choices: list[str]) -> dict[str, Any]:
    """Return the answers as bars, in percent of the longest, or as texts."""
    if kind == SurveyQuestion.Kind.TEXT:
        return {"texts": values[-NEWEST:]}
    counts = Counter(values)
    labels = choices + sorted(set(counts) - set(choices))
    most = max([*counts.values(), 1])
    bars = [{"label": label, "count": counts[label], "share": round(100 * counts[label] / most)} for label in labels]
    numbers = [int(value) for value in values if value in SurveyQuestion(kind=SCALE).choices()] if kind == SCALE else []
    said = answers_in_words(len(values))
    if numbers:
        mean = localize(round(sum(numbers) / len(numbers), 1))
        said = gettext("%(answers)s, mean %(mean)s of 5") % {"answers": said, "mean": mean}
    return {"bars": bars, "summary": said}


@never_cache
@permission_required("operatorlog.view_surveyresponse", raise_exception=True)
def results_csv(request: HttpRequest) -> HttpResponse:
    """Return all answers as CSV."""
    return csv_response(f"farhand-survey-{SYSTEM.now():%Y-%m-%d}", _rows())


def _rows() -> Iterator[list[object]]:
    questions = list(SurveyQuestion.objects.all())
    yield ["turn", "robot", "at", *(q.prompt for q in questions)]
    for one in SurveyResponse.objects.select_related("turn__robot", "robot").prefetch_related("answers"):
        given = {a.question_id: a.value for a in one.answers.all()}
        robot = one.robot or (one.turn.robot if one.turn else None)
        about = [one.turn_id or "", robot.slug if robot else "", one.at.isoformat()]
        yield [*about, *(given.get(q.pk, "") for q in questions)]


def cell(text: str) -> str:
    """Return the text as a cell that no spreadsheet executes: a quote is put before the start of a formula."""
    return f"'{text}" if text.startswith(FORMULA) or text.lstrip().startswith(FORMULA) else text


def csv_response(name: str, rows: Iterable[Sequence[object]]) -> HttpResponse:
    """Return the rows as a download; the byte order mark tells Excel that it is UTF-8."""
    response = HttpResponse(codecs.BOM_UTF8, content_type="text/csv; charset=utf-8")
    response["Content-Disposition"] = f'attachment; filename="{name}.csv"'
    writer = csv.writer(response)
    writer.writerows([cell(str(value)) for value in row] for row in rows)
    return response
