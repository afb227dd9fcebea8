"""Recordings on pages of turns and jobs."""

from collections.abc import Sequence
from datetime import datetime, timedelta
from typing import Any

from django import template

from portal.web.recordings import access, exports, figures
from robots.kit.clock import SYSTEM
from robots.models import Finding, Movie, Recording, Robot
from robots.models.recordings import keep_days
from robots.recordings import movies
from robots.recordings.keeping import recorded

register = template.Library()
LEAD = timedelta(seconds=1)  # a replay begins so long before what happened


@register.simple_tag(takes_context=True)
def recordings_of(context: Any, grant: int) -> list[Recording]:
    """Return the recordings of a grant that this person may know of."""
    request = context.get("request")
    return access.to_offer([grant], request.user) if request is not None else []


@register.filter
def replayable(recordings: list[Recording]) -> bool:
    """Return whether one of them can be replayed."""
    return any(one.replayable for one in recordings)


@register.simple_tag
def replay_at(recordings: list[Recording], moment: datetime) -> str:
    """Return the address of the replay at a moment; empty where no recording that can be replayed contains it."""
    for one in recordings:
        if one.replayable and one.began_at <= moment <= (one.ended_at or moment):
            seconds = max(0.0, (moment - LEAD - one.began_at).total_seconds())
            return f"{one.get_absolute_url()}#at={seconds:.1f}"
    return ""


@register.simple_tag
def films_of(recordings: list[Recording]) -> list[exports.Film]:
    """Return these recordings with the movie of each."""
    return [exports.film_of(recording) for recording in recordings]


@register.simple_tag
def figures_of(robot: Robot, findings: Sequence[Finding], movies: list[exports.Film]) -> list[figures.Figure]:
    """Return a drawing of the path of each run that is known."""
    return figures.figures_of(robot, findings, [film.recording for film in movies])


@register.filter
def arriving(movies: list[exports.Film]) -> bool:
    """Return whether the page has to look again for a movie."""
    return any(film.arriving for film in movies)


@register.filter
def recording_words(recording: Recording) -> str:
    """Say how a recording stands, in a sentence."""
    return access.words_for(recording)


@register.filter
def stale(movie: Movie) -> bool:
    """Return whether no process seems to make movies now."""
    return movies.stale(movie, SYSTEM.now())


@register.filter
def kept_days(robot: Robot) -> int:
    """Return for how many days recordings of this robot are kept; 0 if it is not recorded."""
    return keep_days(robot) if recorded(robot) else 0
