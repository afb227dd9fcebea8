"""Pages: the log, and a turn with its entry and survey."""

from typing import Any

from django.conf import settings
from django.contrib import messages
from django.core.paginator import Paginator
from django.http import Http404, HttpRequest, HttpResponse, JsonResponse
from django.shortcuts import get_object_or_404, redirect, render
from django.utils.translation import gettext
from django.views.decorators.cache import never_cache

from operatorlog import services
from operatorlog.finds import Report, excavation_of
from operatorlog.models import Entry, SurveyQuestion, SurveyResponse, Visibility
from operatorlog.register import dug_map, register_of
from operatorlog.services import may_see_hidden
from operatorlog.steps import steps_of
from queueing.models import Turn
from robots.kit.clock import SYSTEM
from robots.kit.contract.words import place_of
from robots.kit.plain import NUMERAL, whole
from robots.models import Frame, Robot
from robots.people import is_person
from robots.recordings.findings import SHOWN, findings_of, left_out

PAGE = 20
LONGEST_NUMBER = 20  # characters


def log(request: HttpRequest) -> HttpResponse:
    """List the entries that everybody may read, and hidden ones to their author alone."""
    entries = services.entries_for(request.user).select_related("author", "robot", "frame", "turn")
    robot = request.GET.get("robot", "")
    known = Robot.objects.filter(slug=robot).first() if robot else None
    if robot:
        entries = entries.filter(robot__slug=robot)
    unwritten = None
    if request.user.is_authenticated:
        mine = Turn.objects.filter(user=request.user, entry=None, robot__practice_for=None)
        unwritten = mine.exclude(ended_at=None).first()
    page = Paginator(entries, PAGE).get_page(request.GET.get("page"))
    digs = known is not None and excavation_of(known) is not None
    context = {"page": page, "robot": robot, "known": known, "digs": digs, "unwritten": unwritten}
    return render(request, "operatorlog/list.html", context)


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
    if "appeal" in request.POST:
        return _appeal(request, turn)
    text = request.POST.get("text")
    frame = whole(request.POST.get("frame", ""))
    try:
        written, answered, reported = services.hand_in(
            turn, request.user, text, frame, survey_answers(request), SYSTEM.now(), _report(request, frame)
        )
    except services.LogError as error:
        return _show(request, turn, str(error), status=422 if is_person(request.user, turn.user_id) else 403)
    if reported:
        said = gettext("“%(name)s” is reported; a moderator looks at it.")
        messages.success(request, said % {"name": reported.name})
    if written and answered:
        messages.success(request, gettext("It is in the log, and your answers are kept. Thank you!"))
    elif written:
        messages.success(request, gettext("It is in the log. Thank you!"))
    elif answered:
        messages.success(request, gettext("Thank you for your answers!"))
    return redirect(turn)


def _appeal(request: HttpRequest, turn: Turn) -> HttpResponse:
    """Ask for another look at the hidden entry of the turn."""
    entry = get_object_or_404(Entry, turn=turn)
    try:
        services.appeal(entry, request.user, request.POST["appeal"], SYSTEM.now())
    except services.LogError as error:
        return _show(request, turn, str(error), status=422 if is_person(request.user, entry.author_id) else 403)
    messages.success(request, gettext("A moderator will look at your entry again."))
    return redirect(turn)


def _report(request: HttpRequest, frame: int | None) -> Report | None:
    """Return the report of a find in the form, its place in cm; None if there is none. Raises LogError."""
    name = request.POST.get("find", "").strip()
    if not name:
        return None
    x, y = (_metres(request.POST.get(field, "").strip()) for field in ("find_x", "find_y"))
    return Report(name, frame, x, y)


def _metres(text: str) -> float | None:
    """Return a length that was typed in cm; None where nothing was. Raises LogError."""
    if not text:
        return None
    if len(text) > LONGEST_NUMBER or not NUMERAL.fullmatch(text.replace(",", ".")):
        raise services.LogError(gettext("The place of a find is two numbers in cm, or empty."))
    return float(text.replace(",", ".")) / 100


def survey_answers(request: HttpRequest) -> dict[int, str]:
    """Return the survey's answers in a form by question."""
    named = ((whole(name[1:]), str(value)) for name, value in request.POST.items() if name[:1] == "s")
    return {number: value for number, value in named if number is not None}


def _show(request: HttpRequest, turn: Turn, problem: str = "", status: int = 200) -> HttpResponse:
    """Show the turn; after a problem, with the text and answers that the form had."""
    entry = Entry.objects.select_related("author", "robot", "frame", "turn").filter(turn=turn).first()
    mine = is_person(request.user, turn.user_id)
    may_edit = entry is not None and services.may_edit(entry, request.user, SYSTEM.now())
    typed = request.POST.get("text", "")
    editing = may_edit and ("edit" in request.GET or bool(problem and "text" in request.POST))
    hidden = entry is not None and entry.visibility == Visibility.HIDDEN and not may_see_hidden(entry, request.user)
    frames = [] if hidden else list(turn.grant.frames.select_related("robot").order_by("id"))
    chosen = entry.frame_id if entry else (frames[-1].pk if frames else None)
    ended = turn.ended_at is not None
    writing = mine and ended and (entry is None or editing)
    findings = list(findings_of([turn.grant_id]))
    steps, step_pages = steps_of(turn, request.GET.get("page"))
    long = turn.grant.commands.filter(result__has_key="left_out")
    noted = {one.frame_id for one in findings}  # the page shows these pictures beside the findings
    digs = excavation_of(turn.robot) is not None
    reporting = mine and ended and digs
    context = {
        "turn": turn, "site": settings.SITE_ADDRESS, "entry": entry, "mine": mine, "may_edit": may_edit,
        "editing": editing, "problem": problem,
        "writing": writing, "frames": frames, "pictures_hidden": hidden,
        "others": [frame for frame in frames if frame.pk not in noted],
        "chosen": whole(request.POST.get("frame", "")) if problem and "frame" in request.POST else chosen,
        "text": typed or (entry.text if entry and editing else ""), "lost": "" if writing else typed,
        "may_appeal": entry is not None and services.may_appeal(entry, request.user),
        "appeal": entry.appeals.select_related("answer").last() if entry and mine else None,
        "appealed": request.POST.get("appeal", "") if problem else "",
        "survey": _survey(request, turn) if mine and ended else [],
        "steps": steps, "step_pages": step_pages,
        "findings": findings if "all" in request.GET else findings[:SHOWN],
        "all_findings": findings, "findings_in_all": len(findings), "left_out": left_out(long),
        "digs": digs, "reporting": reporting, "places": _places(turn, frames) if reporting else {},
        "finds": turn.finds.select_related("piece") if mine and digs else [],
        "find": {name: request.POST.get(name, "") for name in ("find", "find_x", "find_y")} if problem else {},
    }  # fmt: skip
    return render(request, "operatorlog/turn.html", context, status=status)


def _places(turn: Turn, frames: list[Frame]) -> dict[int, list[float]]:
    """Return x and y (cm) of the robot in each picture, by its primary key: what the form fills in for a find."""
    spec = turn.robot.spec()
    places = {frame.pk: place_of(spec, frame.pose) for frame in frames}
    return {pk: [round(100 * at["x"], 1), round(100 * at["y"], 1)] for pk, at in places.items() if {"x", "y"} <= {*at}}


def _survey(request: HttpRequest, turn: Turn) -> list[dict[str, Any]]:
    """Return the questions, each with the answer just given; none if they were answered before."""
    if SurveyResponse.objects.filter(turn=turn).exists():
        return []
    return survey_form(request, SurveyQuestion.After.TURN)


def survey_form(request: HttpRequest, after: SurveyQuestion.After) -> list[dict[str, Any]]:
    """Return the questions after a turn or a job, each with the answer just given."""
    given = survey_answers(request)
    return [{"q": q, "given": given.get(q.pk, "")} for q in services.questions_after(after)]


def finds(request: HttpRequest, slug: str) -> HttpResponse:
    """Show what was found with a robot, and where it was dug."""
    robot = get_object_or_404(Robot, slug=slug)
    register = register_of(robot)
    if register is None:
        raise Http404("With this robot nothing is hidden.")
    return render(request, "operatorlog/finds.html", {"robot": robot, "register": register})


@never_cache
def dug(request: HttpRequest, slug: str) -> HttpResponse:
    """Tell a console's map what was dug and found; it is read by the page, in the reader's language."""
    shown = dug_map(get_object_or_404(Robot, slug=slug))
    if shown is None:
        raise Http404("With this robot nothing is hidden.")
    return JsonResponse(shown)
