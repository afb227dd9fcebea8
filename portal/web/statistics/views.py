"""`/robots/<slug>/statistics/` and `statistics.json`: the jobs of a robot in any 24 hours."""

from dataclasses import asdict
from datetime import UTC, datetime, timedelta

from django.http import Http404, HttpRequest, HttpResponse, JsonResponse
from django.shortcuts import get_object_or_404, render
from django.utils.timezone import get_current_timezone_name, localtime
from django.utils.translation import gettext
from django.views.decorators.cache import never_cache
from django.views.decorators.http import require_safe

from portal.edge.attempts import within
from portal.web.pages.errors import software_missing
from portal.web.statistics import plots
from portal.web.statistics.day import DAY, BadDate, Span, span_of
from portal.web.statistics.reading import MOST_JOBS, MOST_MOTIONS, record_of
from portal.web.statistics.report import Report, report_of, words_of
from portal.web.translation.english import in_english
from portal.web.translation.middleware import zone_of
from queueing.services import job_kinds
from robots.kit.clock import SYSTEM
from robots.kit.contract.capabilities import Statistics
from robots.models import Robot
from robots.sentences import translate

MINUTE = "%Y-%m-%dT%H:%M"
LATEST = timedelta(minutes=1)  # less than this before now is now


def _needs_jobs(robot: Robot) -> None:
    if not job_kinds(robot):
        raise Http404("This robot takes no jobs, so it has no statistics of jobs.")


def _told(robot: Robot, span: Span, now: datetime) -> Report:
    spec = robot.spec()
    declared = spec.capability(Statistics) or Statistics()
    return report_of(record_of(robot, declared, span, now), spec, declared, span)


class _Refused(Exception):
    def __init__(self, text: str, status: int) -> None:
        super().__init__(text)
        self.status = status


def _span(request: HttpRequest, now: datetime) -> Span:
    """Return the 24 hours that are asked for. Raises _Refused."""
    if not within(request, "statistics"):
        raise _Refused(gettext("Your network asks for statistics too often; ask again in a minute."), 429)
    try:
        return span_of(request.GET.get("from", ""), now, zone_of(request.GET.get("zone", "")) or UTC)
    except BadDate as error:
        raise _Refused(str(error), 400) from error


@never_cache
@require_safe
def statistics(request: HttpRequest, slug: str) -> HttpResponse:
    """Show the statistics of 24 hours: a table, plots, and each plot as a table."""
    robot, now = get_object_or_404(Robot, slug=slug), SYSTEM.now()
    try:
        spec = robot.spec()
    except LookupError:
        return software_missing(request, robot.name)
    _needs_jobs(robot)
    asked, zone = request.GET.get("from", ""), get_current_timezone_name()
    try:
        span = _span(request, now)
    except _Refused as error:
        told_why = {"robot": robot, "wrong": str(error), "asked_here": asked[:40], "zone": zone}
        return render(request, "pages/statistics.html", told_why, status=error.status)
    told = _told(robot, span, now)
    declared, start, words = told.declared, span.start, words_of(told.declared)
    shown = next((c for c in spec.channels if c.name == declared.over_time), None)
    context = {
        "robot": robot, "span": span, "told": told, "wrong": "", "zone": zone,
        **asdict(words), "against": translate(declared.against),
        "asked": span.start.strftime(MINUTE), "asked_here": localtime(span.start).strftime(MINUTE),
        "earlier": (span.start - DAY).strftime(MINUTE),
        "later": span.end.strftime(MINUTE) if span.end + LATEST <= now else "",
        "hours": plots.hours(told.hours, start, words.job, words.jobs, words.done),
        "hour_rows": [(plots.clock_of(start, n), asked, done) for n, (asked, done) in enumerate(told.hours)],
        "success": plots.success(told.success, words.done),
        "channel": shown, "line": plots.line(told.course, shown.low, shown.high, start) if shown else None,
        "most_jobs": MOST_JOBS, "most_motions": MOST_MOTIONS,
    }  # fmt: skip
    return render(request, "pages/statistics.html", context)


@require_safe
@in_english
def statistics_json(request: HttpRequest, slug: str) -> JsonResponse:
    """Return the same for programs. Shared caches keep it, but never a refusal, which is meant for one asker."""
    robot, now = get_object_or_404(Robot, slug=slug), SYSTEM.now()
    _needs_jobs(robot)
    try:
        span = _span(request, now)
    except _Refused as error:
        return JsonResponse({"error": str(error)}, status=error.status, headers={"Cache-Control": "no-store"})
    found = {
        "robot": robot.slug,
        "name": robot.name,
        "simulated": robot.simulated,
        **_told(robot, span, now).as_json(span),
    }
    return JsonResponse(found, headers={"Cache-Control": "public, max-age=60"})
