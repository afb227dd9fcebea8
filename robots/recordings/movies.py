"""Movies of recordings and time-lapses of days: made on request or automatically, one at a time, kept for some days."""

from datetime import date, datetime, timedelta
from pathlib import Path
from typing import Any

from django.conf import settings
from django.db import IntegrityError, transaction
from django.db.models import F

from robots.kit.clock import ms_of
from robots.kit.contract.capabilities import Programs
from robots.kit.contract.errors import BadRequest
from robots.models import Frame, Movie, Recording, Robot
from robots.models.recordings import SHOWN
from robots.recordings import keeping
from robots.recordings.plots import plot_of
from robots.states import ASKED_FOR, GrantKind

WAITING = 20  # movies that may wait to be made
LAPSE_HZ, LAPSE_S = 12, 10.0  # pictures a second of a time-lapse, and seconds of the day between them
FRAMES = 2000  # stored pictures of a day at most
TRIES, AGAIN = 3, timedelta(minutes=5)  # of an automatic movie, and the pause between two
UNASKED, JUDGED = 5, 100  # automatic movies that may wait at once; recordings that one call judges
LATEST = timedelta(days=1)  # after the end of a job or turn; later no movie of it is made automatically
Kind, State = Movie.Kind, Movie.State


def ask(recording: Recording, kind: str, now: datetime) -> Movie:
    """Return the movie of a recording, or create one, which waits to be made. Raises BadRequest."""
    if not recording.replayable:
        raise BadRequest("There is no recording of which a movie could be made.")
    same = {"recording": recording, "kind": _kind(kind), "version": recording.version}
    return _asked(same, Movie(robot=recording.robot, asked_at=now, **same))


def ask_day(robot: Robot, day: date, kind: str, recordings: list[Recording], stills: list[str], now: datetime) -> Movie:
    """Return or create the time-lapse of a robot's day (UTC), of recordings and stored pictures (the oldest first).

    Raises BadRequest.
    """
    if day >= now.date():
        raise BadRequest("A time-lapse is made of a day that is over (UTC).")
    same: dict[str, Any] = {"robot": robot, "day": day, "kind": _kind(kind)}
    shown: list[int | str] = [*(recording.pk for recording in recordings), *stills]
    known = Movie.objects.filter(**same)
    keeping.forget_movies(movie for movie in known if not set(movie.sources) <= set(shown))  # a part is hidden since
    if not shown:
        raise BadRequest("Nothing is kept of that day.")
    return _asked(same, Movie(asked_at=now, sources=shown[: len(recordings) + FRAMES], **same))


def _kind(kind: str) -> str:
    if kind not in Kind.values:
        raise BadRequest("A movie is MP4 or WebM.")
    return kind


def _asked(same: dict[str, Any], new: Movie) -> Movie:
    found = Movie.objects.filter(**same).first()
    if found is not None and found.state != State.FAILED:
        _hasten(found)
        return found
    if Movie.objects.filter(state=State.WAITING, unasked=False).count() >= WAITING:
        raise BadRequest("Too many movies wait to be made; ask again in some minutes.")
    try:
        with transaction.atomic():
            if found is not None:
                found.delete()
            new.save()
    except IntegrityError:  # two requests at once
        return Movie.objects.get(**same)
    return new


def is_filmed(recording: Recording) -> bool:
    """Return whether a movie is made automatically: of a turn with a program, and of a job as its robot declares."""
    try:
        spec = recording.robot.spec()
    except LookupError:  # its package is gone
        return False
    job = recording.grant.kind == GrantKind.JOB
    kinds = spec.filmed() if job else [one.kind for one in spec.all_of(Programs)]
    known = recording.grant.kind in ASKED_FOR and bool(kinds)
    return known and recording.grant.commands.filter(kind__in=kinds).exists()


def ask_due(now: datetime) -> int:
    """Request movies of finished jobs and turns, a few at a time. Return how many are new.

    Each recording is judged once, so a movie that was removed to make room is not made again.
    """
    ended = Recording.objects.filter(state__in=SHOWN, grant__kind__in=ASKED_FOR, ended_at__gt=now - LATEST)
    fresh = ended.filter(filmed__lt=F("version"), grant__ended_at__isnull=False).order_by("id")
    room = UNASKED - Movie.objects.filter(state__in=(State.WAITING, State.MAKING), unasked=True).count()
    count = 0
    for recording in fresh.select_related("robot", "grant")[:JUDGED]:
        filmed = is_filmed(recording)
        row = Recording.objects.filter(pk=recording.pk, filmed__lt=recording.version)
        if (filmed and count >= room) or not row.update(filmed=recording.version) or not filmed:
            continue
        same: dict[str, Any] = {"recording": recording, "kind": Kind.MP4, "version": recording.version}
        defaults = {"robot": recording.robot, "asked_at": now, "unasked": True}
        count += Movie.objects.get_or_create(**same, defaults=defaults)[1]
    return count


def claim(now: datetime) -> Movie | None:
    """Return the next movie to make, requested ones first, and store that it is being made; None if none waits."""
    waiting = Movie.objects.filter(state=State.WAITING).select_related("recording", "robot")
    for movie in waiting.order_by("unasked", "id"):
        if movie.tries and movie.begun_at is not None and timedelta(0) <= now - movie.begun_at < AGAIN:
            continue  # it failed a moment ago
        if Movie.objects.filter(pk=movie.pk, state=State.WAITING).update(state=State.MAKING, begun_at=now, progress=0):
            return movie
    return None


def again() -> None:
    """Put the movies that an interrupted process was making back to the waiting ones."""
    Movie.objects.filter(state=State.MAKING).update(state=State.WAITING, begun_at=None)


def _hasten(movie: Movie) -> None:
    """Treat an automatic movie that waits as requested, because somebody asks for it now."""
    Movie.objects.filter(pk=movie.pk, state=State.WAITING, unasked=True).update(unasked=False, begun_at=None)


def plan_of(movie: Movie) -> dict[str, Any]:
    """Return the plan for the process that makes movies; it has no files if nothing is left."""
    if movie.recording is not None:
        path = keeping.path_of(movie.recording)
        shown = movie.recording.replayable and path.exists()
        files = [(str(path), ms_of(movie.recording.began_at))] if shown else []
        return {"hz": 5, "files": files, "plot": plot_of(movie.recording) if files else None}
    assert movie.day is not None
    recordings = [source for source in movie.sources if isinstance(source, int)]
    pictures = [source for source in movie.sources if isinstance(source, str)]
    kept = Recording.objects.filter(pk__in=recordings, state__in=SHOWN)
    timed = [(recording.began_at, keeping.path_of(recording)) for recording in kept]
    stills = Frame.objects.filter(robot=movie.robot, taken_at__date=movie.day, file__in=pictures)
    timed += [(frame.taken_at, Path(settings.MEDIA_ROOT) / frame.file) for frame in stills]
    there = [(str(path), ms_of(at)) for at, path in sorted(timed) if path.exists()]
    return {"hz": LAPSE_HZ, "every_s": LAPSE_S, "files": there}


def progress(movie: Movie, percent: int) -> None:
    """Store the progress of a movie (percent)."""
    Movie.objects.filter(pk=movie.pk, state=State.MAKING).update(progress=min(100, max(0, percent)))


def finish(movie: Movie, made: Path | None, reason: str, now: datetime) -> None:
    """Store that a movie is ready, or why not. `made` is its file, which is moved to `keeping.movie_path`."""
    done = Movie.objects.filter(pk=movie.pk, state=State.MAKING)
    if made is None:
        tries = movie.tries + 1
        again = movie.unasked and tries < TRIES
        done.update(state=State.WAITING if again else State.FAILED, reason=reason[:200], tries=tries, begun_at=now)
        return
    path = keeping.movie_path(movie)
    if made.exists():  # otherwise an earlier call has moved it and could not store that
        made.replace(path)
    size = path.stat().st_size
    if done.update(state=State.READY, ready_at=now, size=size, reason=""):
        return
    if not Movie.objects.filter(pk=movie.pk, state=State.READY).exists():  # it is if another recorder made it too
        path.unlink(missing_ok=True)  # pictures of it were taken down meanwhile


def note_track(movie: Movie, track: dict[str, Any]) -> None:
    """Store the robot's path in the row of its recording."""
    if movie.recording is not None:
        Recording.objects.filter(pk=movie.recording.pk, state__in=SHOWN).update(track=track)


def stale(movie: Movie, now: datetime) -> bool:
    """Return whether the movie has waited for long, because no process makes movies now."""
    since = max(movie.asked_at, movie.begun_at or movie.asked_at)  # a new try counts from its begin
    return movie.state in (State.WAITING, State.MAKING) and now - since > timedelta(minutes=15)
