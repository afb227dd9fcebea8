"""The movie of the day, which a rule or staff choose, and its page.

The choice is not stored but made again for each request, so a movie that is hidden or removed is gone at once.
"""

from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

from django.db.models import F, QuerySet
from django.http import HttpRequest, HttpResponse
from django.shortcuts import render
from django.views.decorators.cache import never_cache
from django.views.decorators.http import require_safe

from portal.web.recordings import access
from robots.kit.clock import SYSTEM
from robots.models import Movie, Recording, RecordingState
from robots.models.recordings import SHOWN, OfTheDay
from robots.recordings.keeping import movie_path

SHORTEST = timedelta(seconds=10)  # of a recording that the rule chooses
LOOKED = 60  # movies that the rule examines, among them those of guests and of hidden log entries


@dataclass(frozen=True)
class ShownMovie:
    """A movie that everybody may see, with its recording."""

    movie: Movie
    recording: Recording
    about: access.About

    @property
    def title(self) -> str:
        """Return where and when it was taken, without a name: edges and caches keep it for a while."""
        return f"{self.recording.robot.name}, {self.recording.began_at:%-d %B %Y}"

    @property
    def path(self) -> Path:
        """Return where its file is."""
        return movie_path(self.movie)


def movie_of_the_day(now: datetime, viewer: Any = None) -> ShownMovie | None:
    """Return the pinned movie; else the newest of a whole recording that was ready when the day began (UTC).

    Everybody may see it; names are as the viewer may read them. None if there is none.
    """
    midnight = now.replace(hour=0, minute=0, second=0, microsecond=0)
    whole = _ready().filter(recording__state=RecordingState.READY, ready_at__lt=midnight)
    by_rule = whole.filter(recording__ended_at__gte=F("recording__began_at") + SHORTEST)
    pinned = _ready().filter(recording__of_the_day=OfTheDay.PINNED)
    for movie in (*pinned, *by_rule.order_by("-recording__ended_at", "-pk")[:LOOKED]):
        found = _shown(movie, viewer)
        if found is not None:
            return found
    return None


def may_be_shown(key: int) -> bool:
    """Return whether everybody may still see this movie."""
    movie = _ready().filter(pk=key).first()
    return movie is not None and _shown(movie) is not None


def movies_to_keep() -> set[int]:
    """Return the movies that are not removed for their age or size: the one that is shown now."""
    found = movie_of_the_day(SYSTEM.now())
    return set() if found is None else {found.movie.pk}


def _ready() -> QuerySet[Movie]:
    found = Movie.objects.filter(kind=Movie.Kind.MP4, state=Movie.State.READY, version=F("recording__version"))
    found = found.filter(recording__state__in=SHOWN).exclude(recording__of_the_day=OfTheDay.NEVER)
    return found.select_related("recording__robot", "recording__grant")


def _shown(movie: Movie, viewer: Any = None) -> ShownMovie | None:
    assert movie.recording is not None
    about = access.about(movie.recording, viewer)
    return ShownMovie(movie, movie.recording, about) if about is not None and about.public else None


@never_cache
@require_safe
def page(request: HttpRequest) -> HttpResponse:
    """Show the movie of the day, or say that there is none."""
    now = SYSTEM.now()
    found = movie_of_the_day(now, request.user)
    pinned = found is not None and found.recording.of_the_day == OfTheDay.PINNED
    yesterday = (now - timedelta(days=1)).date()
    earlier = found is not None and not pinned and found.recording.began_at.date() < yesterday
    context = {"found": found, "earlier": earlier, "yesterday": yesterday}
    return render(request, "recordings/day.html", context)
