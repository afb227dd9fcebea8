"""The tags by which other sites show a card of a page (Open Graph). No header of a request decides an address."""

from django.conf import settings
from django.contrib.auth.models import AnonymousUser
from django.utils.html import format_html_join
from django.utils.safestring import SafeString
from django.utils.translation import gettext

from portal.live.snapshot import shown_still
from robots.models import Robot
from robots.sentences import declared


def tags(path: str, title: str, description: str, picture: str = "", alt: str = "") -> SafeString:
    """Return the tags for the page at a path of ours; `picture`: the path of its picture, `alt`: what it shows."""
    told = {
        "og:site_name": settings.SITE_NAME, "og:type": "website", "og:title": title, "og:description": description,
        "og:url": f"{settings.SITE_ADDRESS}{path}",
    }  # fmt: skip
    if picture:
        told |= {"og:image": f"{settings.SITE_ADDRESS}{picture}", "og:image:alt": alt}
    shown = format_html_join("\n", '<meta property="{}" content="{}">', told.items())
    return shown + SafeString('\n<meta name="twitter:card" content="summary_large_image">' if picture else "")


def card_of_robot(robot: Robot) -> SafeString:
    """Return the tags of a robot's page, with the newest picture if everybody may see it; none while it is off."""
    if not robot.enabled:
        return SafeString("")
    still = shown_still(robot, AnonymousUser())
    picture = still.url if still is not None else ""
    alt = gettext("The newest picture of the camera of {robot}").format(robot=robot.name)
    return tags(robot.get_absolute_url(), robot.full_name, declared(robot.tagline), picture, alt)
