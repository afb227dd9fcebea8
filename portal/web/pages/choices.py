"""`/me/choices/`: what a person chooses on their own page, a switch each; sent twice, it is the same."""

from django.contrib import messages
from django.contrib.auth.decorators import login_required
from django.http import HttpRequest, HttpResponse
from django.shortcuts import redirect
from django.utils.translation import gettext
from django.views.decorators.http import require_POST

from accounts.models import User
from queueing.models import Turn
from robots import bus
from robots.kit.packets import Changed


@require_POST
@login_required
def choose(request: HttpRequest) -> HttpResponse:
    """Store whether who watches reads the person's name."""
    on = request.POST.get("on") == "on"
    User.objects.filter(pk=request.user.pk or 0).update(name_shown=on)
    for turn in Turn.objects.filter(user=request.user.pk or 0, ended_at=None).select_related("robot"):
        bus.publish_on_commit(turn.robot.slug, Changed("operator"))
    messages.success(request, gettext("Your name is shown.") if on else gettext("Your name is shown to staff alone."))
    return redirect("me")
