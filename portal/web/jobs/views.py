"""`/robots/<slug>/jobs/` and `/jobs/<key>/`: ask for a job, follow it, cancel it. For guests too, without scripts."""

import hashlib
import secrets

from django.contrib import messages
from django.http import HttpRequest, HttpResponse, JsonResponse
from django.shortcuts import get_object_or_404, redirect, render
from django.utils.translation import gettext
from django.views.decorators.cache import never_cache
from django.views.decorators.http import require_http_methods
from django.views.decorators.vary import vary_on_headers

from operatorlog.models import SurveyQuestion
from operatorlog.services import LogError, answer_survey_of_job
from operatorlog.views import survey_answers, survey_form
from portal.edge.addresses import network_of
from portal.edge.attempts import within
from portal.web.jobs.answers import AGAIN_S, job_fields, own_jobs_answer, refusal, status_of, wants_json
from portal.web.jobs.forms import forms, values
from portal.web.jobs.words import request_in_words, result, share_of, stages
from portal.web.pages.places import back_from
from portal.web.recordings.exports import films_of
from portal.web.recordings.figures import figures_of
from queueing import services as queue
from queueing.errors import QueueError, TooOften
from queueing.models import OPEN_JOB, Job, JobState
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import RobotError
from robots.kit.plain import storable, whole
from robots.models import Command, Frame, Robot
from robots.once import FIELD_OF_JOBS, once, press_of, token_of
from robots.recordings.findings import SHOWN as FINDINGS
from robots.recordings.findings import findings_of, left_out
from robots.sentences import translate

GUEST = "farhand_guest"
A_YEAR_S = 365 * 86_400
SHOWN = 30


def asker_of(request: HttpRequest, fresh: str = "") -> queue.Asker:
    """Return who asks: the person, or the guest of a signed cookie; `fresh`: the value of a cookie to be set."""
    if request.user.is_authenticated:
        return queue.Asker(user=request.user)
    cookie = fresh or request.get_signed_cookie(GUEST, default="")
    guest = hashlib.sha256(cookie.encode()).hexdigest() if cookie else ""
    return queue.Asker(guest=guest, network=network_of(request.META.get("REMOTE_ADDR", "")))


@never_cache
@vary_on_headers("Accept")
@require_http_methods(["GET", "HEAD", "POST"])
def jobs_of(request: HttpRequest, slug: str) -> HttpResponse:
    """Show the kinds of jobs that the robot takes and its open jobs; take a new job."""
    robot = get_object_or_404(Robot, slug=slug)
    if request.method == "POST":
        return _act(request, robot)
    if wants_json(request):
        return own_jobs_answer(robot, asker_of(request), SYSTEM.now())
    return _show_all(request, robot)


def _show_all(request: HttpRequest, robot: Robot, problem: str = "", status: int = 200) -> HttpResponse:
    link, waiting = queue.link_of(robot), queue.in_order(robot)
    context = {
        "robot": robot, "any_kinds": queue.job_kinds(robot),
        "forms": forms(robot, request.user, queue.kinds_for(robot, request.user), request.POST),
        "suspended": queue.waits_for_staff(robot), "guests_ask": link is not None and link.guests_ask,
        "jobs": waiting[:SHOWN], "more_jobs": len(waiting) - SHOWN, "problem": problem,
    }  # fmt: skip
    return render(request, "pages/jobs.html", context, status=status)


def _act(request: HttpRequest, robot: Robot) -> HttpResponse:
    try:
        if request.POST.get("do") == "resume":
            queue.resume(robot, request.user, SYSTEM.now())
            messages.success(request, translate(queue.RESUMED))
            return redirect(robot) if request.POST.get("back") == "robot" else redirect("jobs", slug=robot.slug)
        return _ask(request, robot)
    except (QueueError, RobotError) as error:
        if wants_json(request):
            return refusal(error)
        page = _show_all(request, robot, str(error), status_of(error))
        if isinstance(error, TooOften):
            page["Retry-After"] = AGAIN_S
        return page


def _refuse_too_often(request: HttpRequest) -> None:
    """Count a request for a job, of the account or of the network address. Raises TooOften."""
    person = request.user.is_authenticated
    key = f"account {request.user.pk}" if person else f"network {network_of(request.META.get('REMOTE_ADDR', ''))}"
    if not within(request, "ask", key):
        raise TooOften(
            gettext("You ask for jobs too often; ask again in five minutes.")
            if person
            else gettext("Your network asks for jobs too often; ask again in five minutes.")
        )


def _ask(request: HttpRequest, robot: Robot) -> HttpResponse:
    fresh = ""
    if not request.user.is_authenticated and not request.get_signed_cookie(GUEST, default=""):
        fresh = token_of(request, FIELD_OF_JOBS) or secrets.token_urlsafe(24)  # two presses at once are of one guest
    asker, form = asker_of(request, fresh), press_of(request, FIELD_OF_JOBS)
    if queue.job_of_form(robot, asker, form) is None:
        _refuse_too_often(request)
    kind = request.POST.get("kind", "")
    spec = next((k for k in queue.job_kinds(robot) if k.kind == kind), None)
    name = request.POST.get("name", "")
    args = values(robot, spec, request.POST) if spec is not None else {}
    job = queue.ask(
        robot, asker, kind, args, SYSTEM.now(),
        name=name if storable(name) else "", mail=request.POST.get("mail") == "yes", form=form,
        seen_ms=whole(request.POST.get("seen", "")) or 0,
    )  # fmt: skip
    answer: HttpResponse = JsonResponse(job_fields(job), status=201) if wants_json(request) else redirect(job)
    if fresh:
        answer.set_signed_cookie(
            GUEST, fresh, max_age=A_YEAR_S, httponly=True, samesite="Lax", secure=request.is_secure()
        )
    return answer


def _cancel(request: HttpRequest, job: Job, asker: queue.Asker) -> HttpResponse:
    try:
        queue.cancel(job, asker, SYSTEM.now())
    except QueueError as error:
        if wants_json(request):
            return refusal(error)
        messages.warning(request, translate(error))
        return redirect(job)
    if wants_json(request):
        job.refresh_from_db()
        return JsonResponse(job_fields(job))
    messages.success(request, gettext("The job is cancelled; the robot holds."))
    return redirect(job)


@never_cache
@vary_on_headers("Accept")
@require_http_methods(["GET", "HEAD", "POST"])
def job_page(request: HttpRequest, key: str) -> HttpResponse:
    """Show one job to everybody who has its address; its asker and staff may cancel it, its asker answers a survey."""
    job = get_object_or_404(Job.objects.select_related("robot", "user", "queue"), key=key)
    asker, now = asker_of(request), SYSTEM.now()
    if request.method == "POST" and request.POST.get("do") == "survey":
        return _survey(request, job, asker)
    if request.method == "POST" and request.POST.get("do") == "seen":
        queue.mark_seen(job, asker, now)
        return back_from(request)
    if request.method == "POST":
        return _cancel(request, job, asker)
    queue.mark_seen(job, asker, now)
    return _show(request, job, asker)


@once
def _survey(request: HttpRequest, job: Job, asker: queue.Asker) -> HttpResponse:
    if not within(request, "survey"):
        return _show(
            request, job, asker, gettext("Too many answers come from your network; send yours in a minute."), 429
        )
    try:
        answer_survey_of_job(job, asker, survey_answers(request), SYSTEM.now())
    except LogError as error:
        return _show(request, job, asker, str(error), 422 if queue.may_answer(job, asker) else 403)
    messages.success(request, gettext("Thank you for your answers!"))
    return redirect(job)


def _show(request: HttpRequest, job: Job, asker: queue.Asker, problem: str = "", status: int = 200) -> HttpResponse:
    grants = job.runs.values("grant")
    order = queue.forecast(job.robot, SYSTEM.now()) if job.state == JobState.WAITING else []
    ahead = next((one.ahead for one in order if one.job == job), 0)
    commands = list(Command.objects.filter(grant__in=grants).order_by("id"))
    last, mine = commands[-1] if commands else None, queue.may_cancel(job, asker)
    findings, films = list(findings_of(grants)), films_of(grants, request.user)
    recordings = [film.recording for film in films]
    frames = Frame.objects.filter(grant__in=grants, findings=None).select_related("robot").order_by("id")
    everything = "all" in request.GET
    context = {
        "job": job, "open": job.state in OPEN_JOB, "ahead": ahead,
        "suspended": job.state == JobState.WAITING and queue.waits_for_staff(job.robot),
        "asked": request_in_words(job, texts=mine), "texts_hidden": not mine and bool(job.args),
        "result": result(job, last, texts=mine),
        "share": share_of(last),
        "may_cancel": mine,
        "runs": [(number, stages(command)) for number, command in enumerate(commands, 1)],
        "frames": frames if everything else frames[:FINDINGS], "pictures": frames.count(),
        "findings": findings if everything else findings[:FINDINGS],
        "findings_in_all": len(findings), "left_out": left_out(commands),
        "films": films, "found": recordings, "figures": figures_of(job.robot, findings, recordings),
        "survey": survey_form(request, SurveyQuestion.After.JOB) if queue.may_answer(job, asker) else [],
        "problem": problem,
    }  # fmt: skip
    answer = render(request, "pages/job.html", context, status=status)
    if job.user is None:
        answer["X-Robots-Tag"] = "noindex, nofollow"
    return answer
