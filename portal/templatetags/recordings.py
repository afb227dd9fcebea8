"""What pages of turns and jobs tell of recordings."""

from typing import Any

from django import template

from portal.recordings import access
from robots.clock import SYSTEM
from robots.models import Movie, Recording, Robot
from robots.recordings import movies
from robots.recordings.keeping import recorded
from robots.recordings.models import keep_days

register = template.Library()


@register.simple_tag(takes_context=True)
def recordings_of(context: Any, grants: Any) -> list[Recording]:
    """Return the recordings of a grant, or of several, that this person may know of."""
    request = context.get("request")
    wanted = [grants] if isinstance(grants, int) else grants
    return access.to_offer(wanted, request.user) if request is not None else []


@register.filter
def recording_words(recording: Recording) -> str:
    """Say how a recording stands, in a sentence."""
    return access.words_for(recording)


@register.filter
def stale(movie: Movie) -> bool:
    """Return whether nobody seems to make movies now."""
    return movies.stale(movie, SYSTEM.now())


@register.filter
def kept_days(robot: Robot) -> int:
    """Return for how many days what this robot does is kept as a recording; 0 if it is not recorded."""
    return keep_days(robot) if recorded(robot) else 0
