"""The parts of our Atom feeds (RFC 4287) that Django's framework leaves open.

Addresses are those of the configured site: no header of a request decides them.
"""

import re
from collections.abc import Iterable
from datetime import UTC, datetime
from typing import Any

from django.conf import settings
from django.contrib.syndication.views import Feed
from django.http import HttpRequest, HttpResponse
from django.shortcuts import get_object_or_404
from django.urls import reverse
from django.utils.feedgenerator import Atom1Feed
from django.utils.html import linebreaks

from robots.models import Robot

MOST = 30  # items of a feed
NEVER = datetime(2020, 1, 1, tzinfo=UTC)  # of a feed without items; the present time would make each answer another one
FORBIDDEN = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # characters that XML has not


def xml_text(text: str) -> str:
    """Return a text without the characters that XML does not have."""
    return FORBIDDEN.sub("\ufffd", text)


def html_text(text: str) -> str:
    """Return what a person wrote as HTML with nothing of theirs in it but text."""
    return linebreaks(xml_text(text), autoescape=True)


def absolute(path: str) -> str:
    """Return the address of a path of the site."""
    return f"{settings.SITE_ADDRESS}{path}"


class _Atom(Atom1Feed):
    def latest_post_date(self) -> datetime:
        """Return when its newest item was changed."""
        return super().latest_post_date() if self.items else NEVER


class AtomFeed(Feed):  # type: ignore[type-arg]
    """A feed of the whole portal, or of one robot; it is English, as what other software reads is.

    `name` is that of the address for the whole portal; the one for a robot begins with `robot-`.
    """

    feed_type = _Atom
    language = "en"
    name = ""
    subject = ""

    def get_object(self, request: HttpRequest, slug: str = "") -> Robot | None:
        """Return the robot; None: all robots. Raises Http404."""
        return get_object_or_404(Robot, slug=slug) if slug else None

    def title(self, robot: Robot | None) -> str:
        """Return the title of the feed."""
        return xml_text(f"{robot.full_name if robot else settings.SITE_NAME}: {self.subject}")

    def feed_url(self, robot: Robot | None) -> str:
        """Return the feed's own address, which is its id."""
        return absolute(reverse(f"robot-{self.name}", args=[robot.slug]) if robot else reverse(self.name))

    feed_guid = feed_url

    def author_name(self) -> str:
        """Return who publishes the feed."""
        return xml_text(settings.SITE_NAME)

    def __call__(self, request: HttpRequest, *args: Any, **kwargs: Any) -> HttpResponse:
        """Answer with the feed.

        No time says whether a feed has changed: if an entry is hidden, the newest that is left is older. So `ETag`
        alone decides.
        """
        answer = super().__call__(request, *args, **kwargs)
        del answer["Last-Modified"]
        answer["Cache-Control"] = "public, max-age=300"
        return answer

    def items(self, robot: Robot | None) -> Iterable[Any]:
        """Return the newest items."""
        raise NotImplementedError
