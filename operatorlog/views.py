"""The log, a turn's page with its entry and survey, and the survey's results."""

import csv
from collections import Counter
from typing import Any

from django.contrib import messages
from django.contrib.auth.decorators import login_required, permission_required
from django.core.paginator import Paginator
from django.http import HttpRequest, HttpResponse
from django.shortcuts import get_object_or_404, redirect, render
from django.views.decorators.cache import never_cache
from django.views.decorators.http import require_POST

from operatorlog import services
from operatorlog.models import Entry, SurveyQuestion, SurveyResponse, Visibility
from queueing.models import Turn
from robots.clock import SYSTEM

PAGE = 20


def log(request: HttpRequest) -> HttpResponse:
    """List the entries that everybody may read."""
    entries = Entry.objects.exclude(visibility=Visibility.HIDDEN).select_related("author", "robot", "frame", "turn")
    robot = request.GET.get("robot", "")
    if robot:
        entries = entries.filter(robot__slug=robot)
    unwritten = None
    if request.user.is_authenticated:
        unwritten = Turn.objects.filter(user=request.user, entry=None).exclude(ended_at=None).first()
    page = Paginator(entries, PAGE).get_page(request.GET.get("page"))
    return render(request, "operatorlog/list.html", {"page": page, "robot": robot, "unwritten": unwritten})


@never_cache
def turn_page(request: HttpRequest, pk: int) -> HttpResponse:
    """Show a turn; its operator writes the entry here."""
    turn = get_object_or_404(Turn.objects.select_related("user", "robot", "grant"), pk=pk)
    if request.method == "POST":
        return _save(request, turn)
    return _show(request, turn)


def _save(request: HttpRequest, turn: Turn) -> HttpResponse:
    if not request.user.is_authenticated:
        return redirect(f"/accounts/login/?next={turn.get_absolute_url()}")
    frame = request.POST.get("frame", "")
    frame_id = int(frame) if frame.isdigit() else None
    text = request.POST.get("text", "")
    entry = Entry.objects.filter(turn=turn).first()
    try:
        if entry is None:
            services.write(turn, request.user, text, frame_id, SYSTEM.now())
        else:
            services.edit(entry, request.user, text, frame_id, SYSTEM.now())
    except services.LogError as error:
        return _show(request, turn, str(error), text, status=403 if turn.user_id != request.user.pk else 422)
    messages.success(request, "It is in the log. Thank you!")
    return redirect(turn)


def _show(request: HttpRequest, turn: Turn, problem: str = "", text: str = "", status: int = 200) -> HttpResponse:
    entry = Entry.objects.select_related("author", "robot", "frame", "turn").filter(turn=turn).first()
    mine = request.user.pk == turn.user_id
    may_edit = entry is not None and services.may_edit(entry, request.user, SYSTEM.now())
    editing = may_edit and ("edit" in request.GET or bool(problem))
    frames = list(turn.grant.frames.order_by("id"))
    chosen = entry.frame_id if entry else (frames[-1].pk if frames else None)
    ended = turn.ended_at is not None
    answered = SurveyResponse.objects.filter(turn=turn).exists()
    context = {
        "turn": turn, "entry": entry, "mine": mine, "may_edit": may_edit, "editing": editing, "problem": problem,
        "writing": mine and ended and (entry is None or editing), "frames": frames, "chosen": chosen,
        "text": text or (entry.text if entry and editing else ""),
        "survey": SurveyQuestion.objects.filter(active=True) if mine and ended and not answered else None,
        "commands": turn.grant.commands.order_by("id"),
    }  # fmt: skip
    return render(request, "operatorlog/turn.html", context, status=status)


@require_POST
@login_required
def survey(request: HttpRequest, pk: int) -> HttpResponse:
    """Take the answers of the survey."""
    turn = get_object_or_404(Turn, pk=pk)
    answers = {int(k[1:]): str(v) for k, v in request.POST.items() if k[:1] == "s" and k[1:].isdigit()}
    try:
        services.answer_survey(turn, request.user, answers, SYSTEM.now())
    except services.LogError as error:
        return _show(request, turn, str(error), status=403 if turn.user_id != request.user.pk else 422)
    messages.success(request, "Thank you for your answers!")
    return redirect(turn)


@permission_required("operatorlog.view_surveyresponse", raise_exception=True)
def results(request: HttpRequest) -> HttpResponse:
    """Show what people answered, for staff."""
    shown = [_plot(q) for q in SurveyQuestion.objects.all()]
    return render(request, "operatorlog/results.html", {"questions": shown, "total": SurveyResponse.objects.count()})


def _plot(question: SurveyQuestion) -> dict[str, Any]:
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
    summary = f"{len(values)} answers"
    if question.kind == question.Kind.SCALE and values:
        summary += f", mean {sum(map(int, values)) / len(values):.1f} of 5"
    return {"prompt": question.prompt, "bars": bars, "height": 28 * len(bars) + 8, "summary": summary}


@permission_required("operatorlog.view_surveyresponse", raise_exception=True)
def results_csv(request: HttpRequest) -> HttpResponse:
    """Return all answers as CSV; a cell that a spreadsheet might run is quoted."""
    response = HttpResponse(content_type="text/csv; charset=utf-8")
    response["Content-Disposition"] = 'attachment; filename="survey.csv"'
    writer = csv.writer(response)
    questions = list(SurveyQuestion.objects.all())
    writer.writerow(["turn", "robot", "at", *(_cell(q.prompt) for q in questions)])
    for one in SurveyResponse.objects.select_related("turn__robot").prefetch_related("answers"):
        given = {a.question_id: a.value for a in one.answers.all()}
        writer.writerow(
            [one.turn_id, one.turn.robot.slug, one.at.isoformat(), *(_cell(given.get(q.pk, "")) for q in questions)]
        )
    return response


def _cell(text: str) -> str:
    return f"'{text}" if text[:1] in "=+-@\t\r" else text
