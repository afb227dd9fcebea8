"""Variables for every template."""

from typing import Any

from django.db import Error
from django.http import HttpRequest
from django.utils.functional import SimpleLazyObject

from accounts.adapter import mails_go_to_terminal
from accounts.turn_mails import mail_choice
from portal.live.standing import place_info
from portal.stores import trouble
from portal.web.jobs.views import asker_of
from portal.web.push.messages import public_key
from portal.web.push.views import subscription_number
from queueing.models import Job
from queueing.services import standings, unseen_jobs
from robots.kit.clock import SYSTEM
from robots.models import Robot
from robots.prepared import Prepared

_MENU: Prepared[Robot] = Prepared(lambda: Robot.objects.filter(enabled=True, practice_for=None).only("slug", "name"))

MAIL = {None: "", False: "off", True: "on"}  # as the bar and the person's page have it


def _my_places(user: Any) -> list[dict[str, Any]]:
    now = SYSTEM.now()
    return [place_info(one, now) for one in standings(user, now)]


def _ended_jobs(request: HttpRequest) -> list[Job]:
    """Return ended jobs that the person or guest has not looked at; none while the database is away."""
    try:
        return unseen_jobs(asker_of(request), SYSTEM.now())
    except Error:
        return []


def site(request: HttpRequest) -> dict[str, object]:
    """Return the robots for the menu and the person's places.

    They are read when a template uses them first, and once for a page.
    """
    user = getattr(request, "user", None)
    return {
        "menu_robots": SimpleLazyObject(_MENU),
        "store_trouble": trouble(),
        "mails_to_terminal": mails_go_to_terminal(),
        "ended_jobs": SimpleLazyObject(lambda: _ended_jobs(request)),
        "push_key": SimpleLazyObject(public_key),
        "turn_mail": SimpleLazyObject(lambda: MAIL[mail_choice(user)]),
        "subscription_here": SimpleLazyObject(lambda: subscription_number(request)),
        "my_places": SimpleLazyObject(lambda: _my_places(user)),
    }
