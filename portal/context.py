"""What every template knows."""

from typing import Any

from django.http import HttpRequest
from django.utils.functional import SimpleLazyObject

from portal.live.standing import place_info
from portal.stores import trouble
from queueing.places import standings
from robots.clock import SYSTEM
from robots.models import Robot


def _my_places(user: Any) -> list[dict[str, Any]]:
    now = SYSTEM.now()
    return [place_info(one, now) for one in standings(user, now)]


def site(request: HttpRequest) -> dict[str, object]:
    """Return the robots for the menu and where the person stands; a slow line is asked nothing more.

    The places are looked up only on pages that show them.
    """
    user = getattr(request, "user", None)
    return {
        "menu_robots": Robot.objects.filter(enabled=True).only("slug", "name"),
        "store_trouble": trouble(),
        "my_places": SimpleLazyObject(lambda: _my_places(user)),
    }
