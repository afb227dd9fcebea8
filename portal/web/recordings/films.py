"""The movies of jobs and turns that come by themselves, for their pages."""

from dataclasses import dataclass
from datetime import timedelta
from typing import Any

from portal.web.recordings import access
from robots.kit.clock import SYSTEM
from robots.models import Movie, Recording, RecordingState
from robots.recordings.movies import is_filmed

SOON = timedelta(minutes=15)  # after the end its page looks for the movie by itself no longer


@dataclass(frozen=True)
class Film:
    """A run's recording, its movie as MP4 where there is one, and whether one comes by itself soon."""

    recording: Recording
    movie: Movie | None
    due: bool

    @property
    def arriving(self) -> bool:
        """Return whether the page has to look for it again."""
        return self.due or (self.movie is not None and self.movie.open)

    @property
    def waits(self) -> bool:
        """Return whether it could not be made just now and is tried again."""
        return self.movie is not None and self.movie.state == Movie.State.WAITING and self.movie.tries > 0


def films_of(grants: Any, user: Any) -> list[Film]:
    """Return the recordings of these grants that this person may see, with the movie of each."""
    return [film_of(recording) for recording in access.to_offer(grants, user)]


def film_of(recording: Recording) -> Film:
    """Return a recording with its movie."""
    movies = recording.movies.filter(version=recording.version, kind=Movie.Kind.MP4)
    movie = movies.first() if recording.replayable else None
    running = recording.state == RecordingState.RUNNING
    ended = recording.ended_at or recording.grant.ended_at
    soon = ended is not None and timedelta(0) <= SYSTEM.now() - ended < SOON
    new = recording.replayable and movie is None and recording.filmed < recording.version
    return Film(recording, movie, soon and (running or new) and is_filmed(recording))
