"""The results of the survey for staff: plots, and all answers as CSV."""

import csv
from collections import Counter
from typing import Any

from django.contrib.auth.decorators import permission_required
from django.http import HttpRequest, HttpResponse
from django.shortcuts import render
from django.utils.translation import ngettext
from django.views.decorators.cache import never_cache

from operatorlog.models import SurveyQuestion, SurveyResponse

# characters that start a formula in some spreadsheet
RUN = (
    "=",
    "+",
    "-",
    "@",
    "\t",
    "\r",
    "\n",
    "＝",
    "＋",
    "－",
    "＠",
)


def counted(count: int) -> str:
    """Return a number of answers as text."""
    return ngettext("%d answer", "%d answers", count) % count


def cell(text: str) -> str:
    """Return the text as a cell that no spreadsheet executes: a quote is put before the start of a formula."""
    return f"'{text}" if text.startswith(RUN) or text.lstrip().startswith(RUN) else text


@never_cache
@permission_required("operatorlog.view_surveyresponse", raise_exception=True)
def results(request: HttpRequest) -> HttpResponse:
    """Show the answers to staff."""
    shown = [plot(q) for q in SurveyQuestion.objects.all()]
    return render(request, "operatorlog/results.html", {"questions": shown, "total": SurveyResponse.objects.count()})


def plot(question: SurveyQuestion) -> dict[str, Any]:
    """Return the plot of a question: bars in pixels, or texts."""
    values = list(question.answers.values_list("value", flat=True))
    if question.kind == question.Kind.TEXT:
        return {"prompt": question.prompt, "texts": values[-100:]}
    counts = Counter(values)
    labels = question.choices() + sorted(set(counts) - set(question.choices()))
    most = max([*counts.values(), 1])
    bars = [
        {
            "label": label, "count": counts[label], "y": 28 * i + 4, "text_y": 28 * i + 19,
            "width": round(300 * counts[label] / most), "text_x": 158 + round(300 * counts[label] / most),
        }
        for i, label in enumerate(labels)
    ]  # fmt: skip
    summary = counted(len(values))
    if question.kind == question.Kind.SCALE and values:
        summary += f", mean {sum(map(int, values)) / len(values):.1f} of 5"
    return {"prompt": question.prompt, "bars": bars, "height": 28 * len(bars) + 8, "summary": summary}


@never_cache
@permission_required("operatorlog.view_surveyresponse", raise_exception=True)
def results_csv(request: HttpRequest) -> HttpResponse:
    """Return all answers as CSV; cells that a spreadsheet might execute are quoted."""
    response = HttpResponse(content_type="text/csv; charset=utf-8")
    response["Content-Disposition"] = 'attachment; filename="survey.csv"'
    writer = csv.writer(response)
    questions = list(SurveyQuestion.objects.all())
    writer.writerow(["turn", "robot", "at", *(cell(q.prompt) for q in questions)])
    for one in SurveyResponse.objects.select_related("turn__robot", "robot").prefetch_related("answers"):
        given = {a.question_id: a.value for a in one.answers.all()}
        robot = one.robot or (one.turn.robot if one.turn else None)
        writer.writerow(
            [cell(str(v)) for v in (one.turn_id or "", robot.slug if robot else "", one.at.isoformat())]
            + [cell(given.get(q.pk, "")) for q in questions]
        )
    return response
