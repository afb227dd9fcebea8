"""Pages of the orientation and the clearance test."""

from dataclasses import replace

from django.contrib import messages
from django.contrib.auth.decorators import login_required
from django.http import Http404, HttpRequest, HttpResponse
from django.shortcuts import get_object_or_404, redirect, render
from django.utils.safestring import mark_safe
from django.utils.translation import get_language, gettext
from django.views.decorators.cache import never_cache

from accounts import services
from accounts.models import Attempt
from accounts.orientation import ENGLISH, anchor, heading, picture, shapes
from accounts.orientation import orientation as orientation_in
from robots.kit.clock import SYSTEM
from robots.kit.plain import whole
from robots.models import Robot


def orientation(request: HttpRequest, slug: str) -> HttpResponse:
    """Show the orientation; when it is marked as read, go on to the test."""
    robot = get_object_or_404(Robot, slug=slug, practice_for=None)
    if request.method == "POST" and request.user.is_authenticated:
        services.mark_read(request.user, robot, SYSTEM.now())
        return redirect(f"/robots/{slug}/clearance/")
    rendered = orientation_in(robot.driver, get_language() or ENGLISH)
    context = {
        "robot": robot, "language": rendered.language,
        "shapes": shapes(robot.driver, rendered.controls, rendered.language),
        "text": mark_safe(rendered.html),  # noqa: S308 - the driver's own text, HTML in it is escaped
        "cleared": services.cleared(request.user, robot), "twin": robot.twin,
    }  # fmt: skip
    return render(request, "accounts/orientation.html", context)


def orientation_picture(request: HttpRequest, slug: str, look: str) -> HttpResponse:
    """Serve a picture of the robot's page, for its orientation."""
    robot = get_object_or_404(Robot, slug=slug)
    try:
        content = picture(robot.driver, look)
    except (LookupError, OSError, ImportError) as error:
        raise Http404("There is no such picture.") from error
    return HttpResponse(content, content_type="image/webp", headers={"Cache-Control": "public, max-age=3600"})


@never_cache
@login_required
def clearance(request: HttpRequest, slug: str) -> HttpResponse:
    """Show the drawn questions, or grade them; `attempt` in the address: what was wrong in a failed one."""
    robot = get_object_or_404(Robot, slug=slug, practice_for=None)
    if services.cleared(request.user, robot):
        messages.success(request, gettext("You are cleared for %(robot)s.") % {"robot": robot.full_name})
        return redirect(robot)
    if not services.has_read(request.user, robot):
        messages.warning(request, gettext("Read the orientation first; the test asks about it."))
        return redirect(f"/robots/{slug}/orientation/")
    if request.method == "POST":
        return _grade(request, robot)
    failed = Attempt.objects.filter(
        pk=whole(request.GET.get("attempt", "")) or 0, user=request.user.pk, robot=robot
    ).first()
    if failed is not None and (hints := services.hints_of(failed)):
        return _show_failed(request, robot, hints)
    try:
        attempt = services.begin(request.user, robot, SYSTEM.now())
    except services.NotNow as error:
        context = {"robot": robot, "notice": str(error), "pause_s": error.wait_s}
        return render(request, "accounts/clearance.html", context, status=409)
    shown = services.questions(attempt)
    return render(request, "accounts/clearance.html", {"robot": robot, "attempt": attempt, "questions": shown})


def _grade(request: HttpRequest, robot: Robot) -> HttpResponse:
    pk = request.POST.get("attempt", "")
    attempt = get_object_or_404(Attempt, pk=whole(pk) or 0, user=request.user, robot=robot)
    shown = services.questions(attempt)
    answers = {}
    for question in shown:
        if (value := whole(request.POST.get(f"q{question.id}", ""))) is not None:
            answers[question.id] = value
    try:
        hints = services.grade(attempt, request.user, answers, SYSTEM.now())
    except services.NotNow as error:
        kept = [replace(q, chosen=answers.get(q.id)) for q in shown]
        context = {"robot": robot, "notice": str(error), "attempt": attempt, "questions": kept, "pause_s": error.wait_s}
        attempt.refresh_from_db()
        if attempt.finished_at is not None or error.wait_s:
            context.pop("questions")
        return render(request, "accounts/clearance.html", context, status=409)
    if not hints:
        if request.POST.get("then") == "take":
            request.session[services.TAKE] = robot.slug
        messages.success(request, gettext("Passed. You are cleared for %(robot)s.") % {"robot": robot.full_name})
        return redirect(robot)
    return redirect(f"{request.path}?attempt={attempt.pk}")  # a page to which one can go back


def _show_failed(request: HttpRequest, robot: Robot, hints: list[services.Hint]) -> HttpResponse:
    """Show what to read again after a failed test."""
    pause_s = services.pause_left(request.user, robot, SYSTEM.now())
    language = get_language() or ENGLISH
    places = [
        {
            "topic": hint.topic, "paragraph": hint.paragraph, "section": heading(robot.driver, hint.section, language),
            "anchor": anchor(hint.section, hint.paragraph) if hint.section else "",
        }
        for hint in hints
    ]  # fmt: skip
    context = {"robot": robot, "hints": places, "pause_s": pause_s, "pause": services.in_words(pause_s)}
    return render(request, "accounts/clearance.html", context)
