"""The survey's results for staff: plots, and all answers as CSV."""

import csv
from collections import Counter
from typing import Any

from django.contrib.auth.decorators import permission_required
from django.http import HttpRequest, HttpResponse
from django.shortcuts import render
from django.utils.translation import ngettext
from django.views.decorators.cache import never_cache

from operatorlog.models import SurveyQuestion, SurveyResponse

# what begins a formula in one spreadsheet or another
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
    """Return so many answers in words."""
    return ngettext("%d answer", "%d answers", count) % count


def cell(text: str) -> str:
    """Return the text as a cell that no spreadsheet runs: what would begin a formula follows a quote."""
    return f"'{text}" if text.startswith(RUN) or text.lstrip().startswith(RUN) else text


@never_cache
@permission_required("operatorlog.view_surveyresponse", raise_exception=True)
def results(request: HttpRequest) -> HttpResponse:
    """Show what people answered, for staff."""
    shown = [plot(q) for q in SurveyQuestion.objects.all()]
    return render(request, "operatorlog/results.html", {"questions": shown, "total": SurveyResponse.objects.count()})


def plot(question: SurveyQuestion) -> dict[str, Any]:
    """Return what the page draws of a question's answers: bars in pixels, or texts."""
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
    """Return all answers as CSV; a cell that a spreadsheet might run is quoted."""
    response = HttpResponse(content_type="text/csv; charset=utf-8")
    response["Content-Disposition"] = 'attachment; filename="survey.csv"'
    writer = csv.writer(response)
    questions = list(SurveyQuestion.objects.all())
    writer.writerow(["turn", "robot", "at", *(cell(q.prompt) for q in questions)])
    for one in SurveyResponse.objects.select_related("turn__robot").prefetch_related("answers"):
        given = {a.question_id: a.value for a in one.answers.all()}
        writer.writerow(
            [cell(str(v)) for v in (one.turn_id, one.turn.robot.slug, one.at.isoformat())]
            + [cell(given.get(q.pk, "")) for q in questions]
        )
    return response
