"""What every template knows."""

from django.http import HttpRequest

from portal.stores import trouble
from robots.models import Robot


def site(request: HttpRequest) -> dict[str, object]:
    """Return the robots for the menu; a slow line is asked nothing more."""
    return {"menu_robots": Robot.objects.filter(enabled=True).only("slug", "name"), "store_trouble": trouble()}
