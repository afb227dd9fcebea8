"""What every template knows."""

from django.http import HttpRequest
from django.utils.functional import SimpleLazyObject

from portal.live.standing import places
from portal.stores import trouble
from robots.clock import SYSTEM
from robots.models import Robot


def site(request: HttpRequest) -> dict[str, object]:
    """Return the robots for the menu and where the person stands; a slow line is asked nothing more.

    The places are looked up only on pages that show them.
    """
    user = getattr(request, "user", None)
    return {
        "menu_robots": Robot.objects.filter(enabled=True).only("slug", "name"),
        "store_trouble": trouble(),
        "my_places": SimpleLazyObject(lambda: places(user, SYSTEM.now())["places"]),
    }
