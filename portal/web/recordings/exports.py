"""Movies of recordings, and time-lapses of days: asked for by a form, downloaded when they are made.

Movies of jobs and of some turns are made without a form; their pages show them as films.
"""

from dataclasses import dataclass
from datetime import date, timedelta
from typing import Any

from django.contrib import messages
from django.http import Http404, HttpRequest, HttpResponse, HttpResponseBase
from django.shortcuts import get_object_or_404, redirect
from django.utils.translation import gettext, gettext_lazy
from django.views.decorators.cache import never_cache
from django.views.decorators.http import require_POST, require_safe

from operatorlog.services import stills_of
from portal.edge.attempts import within
from portal.web.pages.serving import file_response, limit_rate
from portal.web.recordings import access
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import BadRequest
from robots.models import Movie, Recording, RecordingState, Robot
from robots.models.recordings import SHOWN
from robots.recordings import keeping, movies
from robots.sentences import translate

MEDIA = {"mp4": "video/mp4", "webm": "video/webm"}
TOO_OFTEN = gettext_lazy("Your network asks for too many movies; ask again in an hour.")
MADE_SOON = gettext_lazy(
    "The movie is being made. This takes up to some minutes; this page shows how far it is, and then the movie."
)
SOON = timedelta(minutes=15)  # after the end of a run: later its page waits no more for a movie that was not asked for


def _tell_soon(request: HttpRequest, movie: Movie) -> None:
    if movie.state != Movie.State.READY:
        messages.info(request, str(MADE_SOON))


@require_POST
def ask_movie(request: HttpRequest, key: str) -> HttpResponse:
    """Have a movie of a recording made."""
    recording, _ = access.visible(key, request.user)
    if not within(request, "movie"):
        messages.warning(request, str(TOO_OFTEN))
        return redirect(recording)
    try:
        _tell_soon(request, movies.ask(recording, request.POST.get("kind", ""), SYSTEM.now()))
    except BadRequest as error:
        messages.warning(request, translate(error))
    return redirect(recording)


@never_cache
@require_safe
@limit_rate()
def movie(request: HttpRequest, key: str, kind: str) -> HttpResponseBase:
    """Return the movie of a recording."""
    recording, _ = access.visible(key, request.user)
    found = recording.movies.filter(kind=kind, version=recording.version, state=Movie.State.READY).first()
    return _served(request, found, f"{recording.robot.slug}-{recording.began_at:%Y%m%d-%H%M%S}.{kind}")


def _served(request: HttpRequest, found: Movie | None, name: str) -> HttpResponseBase:
    if found is None:
        raise Http404("There is no such movie now; ask for it on the page of the recording.")
    return file_response(request, keeping.movie_path(found), MEDIA[found.kind], name)


def of_day(robot: Robot, day: date) -> list[Recording]:
    """Return the recordings that a time-lapse may show: everybody may see their pictures."""
    found = Recording.objects.filter(robot=robot, began_at__date=day, state__in=SHOWN).select_related("grant")
    about = [(recording, access.about(recording)) for recording in found.order_by("began_at")]
    return [recording for recording, one in about if one is not None and not one.hidden]


def _shown(robot: Robot, day: date) -> set[int | str]:
    return {*(one.pk for one in of_day(robot, day)), *stills_of(robot, day)}


def day_of(text: str) -> date:
    """Return the day in an address. Raises Http404."""
    try:
        return date.fromisoformat(text)
    except ValueError as error:
        raise Http404("A day is written like 2026-11-23.") from error


@require_POST
def ask_lapse(request: HttpRequest, slug: str) -> HttpResponse:
    """Have a time-lapse of a day made."""
    robot = get_object_or_404(Robot, slug=slug)
    back = redirect("recordings", slug)
    if not within(request, "movie"):
        messages.warning(request, str(TOO_OFTEN))
        return back
    try:
        day = date.fromisoformat(request.POST.get("day", ""))
        shown = of_day(robot, day), stills_of(robot, day)
        _tell_soon(request, movies.ask_day(robot, day, request.POST.get("kind", ""), *shown, SYSTEM.now()))
    except ValueError:
        messages.warning(request, gettext("Choose a day."))
    except BadRequest as error:
        messages.warning(request, translate(error))
    return back


@never_cache
@require_safe
@limit_rate()
def lapse(request: HttpRequest, slug: str, day: str, kind: str) -> HttpResponseBase:
    """Return the time-lapse of a day."""
    robot, its_day = get_object_or_404(Robot, slug=slug), day_of(day)
    found = Movie.objects.filter(robot=robot, day=its_day, kind=kind, state=Movie.State.READY).first()
    if found is not None and not set(found.sources) <= _shown(robot, its_day):
        found = None  # one of its recordings or pictures was removed or hidden since
    return _served(request, found, f"{robot.slug}-{day}.{kind}")


def movies_of(recording: Recording) -> list[dict[str, Any]]:
    """Return each kind of movie, with the recording's movie of that kind."""
    found = {one.kind: one for one in recording.movies.filter(version=recording.version)}
    return [{"kind": kind, "label": label, "movie": found.get(kind)} for kind, label in Movie.Kind.choices]


@dataclass(frozen=True)
class Film:
    """The recording of a run, its movie as MP4 if there is one; `due`: a movie will be made soon without a form."""

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
    made = recording.movies.filter(version=recording.version, kind=Movie.Kind.MP4)
    movie = made.first() if recording.replayable else None
    running = recording.state == RecordingState.RUNNING
    ended = recording.ended_at or recording.grant.ended_at
    soon = ended is not None and timedelta(0) <= SYSTEM.now() - ended < SOON
    new = recording.replayable and movie is None and recording.filmed < recording.version
    return Film(recording, movie, soon and (running or new) and movies.is_filmed(recording))
