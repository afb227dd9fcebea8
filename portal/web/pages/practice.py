"""Practice on a simulator, also by guests, who have no account and are signed in nowhere else."""

import re
from collections.abc import Callable
from functools import partial
from typing import Any

from django.conf import settings
from django.contrib.auth import login
from django.contrib.auth.models import AnonymousUser
from django.http import HttpRequest, HttpResponse
from django.shortcuts import get_object_or_404, redirect
from django.urls import reverse
from django.utils.functional import SimpleLazyObject
from django.utils.http import urlencode
from django.views.decorators.http import require_POST

from accounts.services import TAKE, is_seen, new_guest
from portal.edge.attempts import within
from portal.web.pages.errors import too_many
from robots.kit.clock import SYSTEM
from robots.models import Robot

OF_A_ROBOT = re.compile(r"/robots/([-\w]+)/")
BACKEND = settings.AUTHENTICATION_BACKENDS[0]


class Guests:
    """Middleware by which a guest is signed in on the pages of robots for practice alone."""

    def __init__(self, get_response: Callable[[HttpRequest], HttpResponse]) -> None:
        self._get_response = get_response

    def __call__(self, request: HttpRequest) -> HttpResponse:
        """Answer with the person as this page sees them; nothing is read before a view asks who it is."""
        request.user = SimpleLazyObject(partial(_seen, request.user, request.path))  # type: ignore[assignment]
        return self._get_response(request)


def _seen(user: Any, path: str) -> Any:
    robot = OF_A_ROBOT.match(path)
    return user if path == reverse("places") or is_seen(user, robot[1] if robot else "") else AnonymousUser()


@require_POST
def practise(request: HttpRequest, slug: str) -> HttpResponse:
    """Begin to practise, without an account where the robot allows it."""
    robot = get_object_or_404(Robot, slug=slug, practice_for__isnull=False)
    if not request.user.is_authenticated:
        if robot.guest_s is None:
            return redirect(f"{reverse('account_signup')}?{urlencode({'next': robot.get_absolute_url()})}")
        if not within(request, "practice"):
            return too_many(request)
        login(request, new_guest(SYSTEM.now()), BACKEND)
    request.session[TAKE] = robot.slug
    return redirect(robot)
