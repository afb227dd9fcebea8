"""`log.atom` and `status.atom`, of the whole portal and of a robot: the newest items, the same for everybody.

They use no session: nothing of the person who asks is in them.
"""

from collections.abc import Callable, Iterable
from datetime import datetime

from django.conf import settings
from django.contrib.auth.models import AnonymousUser
from django.http import HttpRequest, HttpResponse, HttpResponseBase
from django.urls import reverse
from django.utils.feedgenerator import Enclosure, get_tag_uri
from django.views.decorators.http import conditional_page, require_safe

from operatorlog.models import Entry
from operatorlog.services import entries_for
from portal.web.feeds.atom import MOST, AtomFeed, absolute, html_text, xml_text
from portal.web.feeds.following import listed
from portal.web.feeds.models import Downtime
from portal.web.pages.serving import limit_rate
from portal.web.translation.english import in_english
from robots.kit.clock import SYSTEM
from robots.models import Robot

MINUTE = "%Y-%m-%d %H:%M UTC"


class LogFeed(AtomFeed):
    """The entries of the operator's log that everybody may read."""

    name, subject = "log-feed", "operator's log"

    def link(self, robot: Robot | None) -> str:
        """Return the address of the page."""
        return absolute(reverse("log") + (f"?robot={robot.slug}" if robot else ""))

    def items(self, robot: Robot | None) -> Iterable[Entry]:
        """Return the newest entries."""
        entries = (
            entries_for(AnonymousUser())
            .select_related("author", "robot", "frame", "turn")
            .order_by("-written_at", "-id")
        )
        return (entries.filter(robot=robot) if robot else entries)[:MOST]

    def item_title(self, entry: Entry) -> str:
        """Return who wrote about which robot."""
        return xml_text(f"{entry.author_name} on {entry.robot.full_name}")

    def item_description(self, entry: Entry) -> str:
        """Return the text."""
        return html_text(entry.text)

    def item_author_name(self, entry: Entry) -> str:
        """Return the name that everybody may read."""
        return xml_text(entry.author_name)

    def item_link(self, entry: Entry) -> str:
        """Return the address of the turn, which is the entry's id, too: a turn has one entry."""
        return absolute(entry.turn.get_absolute_url())

    def item_pubdate(self, entry: Entry) -> datetime:
        """Return when it was written."""
        return entry.written_at

    def item_updateddate(self, entry: Entry) -> datetime:
        """Return when its author last changed it."""
        return entry.edited_at or entry.written_at

    def item_enclosures(self, entry: Entry) -> list[Enclosure]:
        """Return the picture."""
        if entry.frame is None:
            return []
        try:
            size = (settings.MEDIA_ROOT / entry.frame.file).stat().st_size
        except OSError:
            return []
        return [Enclosure(absolute(entry.frame.url), str(size), "image/jpeg")]


class StatusFeed(AtomFeed):
    """The times in which nobody could drive a robot; one item each, which is updated when it is over."""

    name, subject = "status-feed", "status"

    def link(self, robot: Robot | None) -> str:
        """Return the address of the page."""
        return absolute(reverse("status"))

    def items(self, robot: Robot | None) -> Iterable[Downtime]:
        """Return the newest times."""
        found = listed(SYSTEM.now())
        return (found.filter(robot=robot) if robot else found)[:MOST]

    def item_title(self, one: Downtime) -> str:
        """Return the robot and its state."""
        return xml_text(f"{one.robot.full_name}: {'in service again' if one.ended_at else one.label}")

    def item_description(self, one: Downtime) -> str:
        """Return since when, and while it lasts why, as the status page says it."""
        began = one.began_at.strftime(MINUTE)
        if one.ended_at:
            return html_text(f"{one.label} from {began} to {one.ended_at.strftime(MINUTE)}.")
        return html_text(f"{one.label} since {began}. {one.reason}".strip())

    def item_link(self, one: Downtime) -> str:
        """Return the address of the robot's page."""
        return absolute(one.robot.get_absolute_url())

    def item_guid(self, one: Downtime) -> str:
        """Return what is the same when it is over."""
        return str(get_tag_uri(absolute(f"{reverse('status')}{one.pk}"), one.began_at))

    def item_pubdate(self, one: Downtime) -> datetime:
        """Return when it began."""
        return one.began_at

    def item_updateddate(self, one: Downtime) -> datetime:
        """Return when anything of it last changed."""
        return one.changed_at


def _view(feed: AtomFeed) -> Callable[..., HttpResponseBase]:
    @require_safe
    @in_english
    @limit_rate()
    @conditional_page
    def answer(request: HttpRequest, slug: str = "") -> HttpResponse:
        return feed(request, slug=slug)

    return answer


log, status = _view(LogFeed()), _view(StatusFeed())
