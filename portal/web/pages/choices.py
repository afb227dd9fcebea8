"""`/me/choices/`: what a person chooses on their own page or in the bar, a switch each; sent twice, it is the same."""

from typing import Any

from django.contrib import messages
from django.contrib.auth.decorators import login_required
from django.http import HttpRequest, HttpResponse, JsonResponse
from django.shortcuts import redirect
from django.utils.translation import gettext
from django.views.decorators.http import require_POST

from accounts.models import User
from accounts.turn_mails import MailRefused, choose_mail
from portal.edge.attempts import within
from queueing.models import Turn
from robots import bus
from robots.kit.packets import Changed


@require_POST
@login_required
def choose(request: HttpRequest) -> HttpResponse:
    """Switch on or off (`on`) what `do` names; a script that asks for JSON gets `text`, which says what is now.

    `name`: who watches reads the person's name. `mail`: an e-mail, too, tells the person that it is their turn.
    """
    choice, on = CHOICES.get(request.POST.get("do", "")), request.POST.get("on") == "on"
    if choice is None:
        return _answer(request, 400, gettext("That request is unknown; reload the page."))
    if not within(request, "choices"):
        return _answer(request, 429, gettext("Too many changes within a minute. Try again in a minute."))
    try:
        return _answer(request, 200, choice(request.user, on))
    except MailRefused as error:
        return _answer(request, 400, str(error))


def _choose_name(user: Any, on: bool) -> str:
    User.objects.filter(pk=user.pk).update(name_shown=on)
    for turn in Turn.objects.filter(user=user.pk, ended_at=None).select_related("robot"):
        bus.publish_on_commit(turn.robot.slug, Changed("operator"))
    return gettext("Your name is shown.") if on else gettext("Your name is shown to staff alone.")


def _choose_mail(user: Any, on: bool) -> str:
    choose_mail(user, on)
    return gettext("An e-mail, too, tells you that it is your turn.") if on else gettext("No e-mail tells you of it.")


CHOICES = {"name": _choose_name, "mail": _choose_mail}


def _answer(request: HttpRequest, status: int, said: str) -> HttpResponse:
    """Answer a script; lead a form back to the person's page."""
    if not request.accepts("text/html"):
        return JsonResponse({"ok": status == 200, "text": said}, status=status)
    (messages.success if status == 200 else messages.warning)(request, said)
    return redirect("me")
