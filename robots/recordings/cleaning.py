"""Housekeeping of recordings and movies: removes old ones, by the times of rows and never by those of files."""

import contextlib
import logging
from collections.abc import Callable
from datetime import datetime, timedelta
from pathlib import Path

from django.conf import settings
from django.db.models import Sum

from robots.models import Movie, Recording, RecordingState, Robot
from robots.models.recordings import SHOWN, keep_days
from robots.recordings import keeping
from robots.wall_clock import FIRST

log = logging.getLogger(__name__)
needed: list[Callable[[], set[int]]] = []  # each returns the keys of movies that an app still shows, and that stay
ALONE = timedelta(hours=1)  # a recorder that has not finished this long after the grant is given up


def clean(now: datetime) -> int:
    """Remove old recordings, the oldest of a robot that has too many, old movies, and orphaned files.

    Return how many.
    """
    removed = 0
    gone = Recording.objects.filter(state=RecordingState.RUNNING, grant__ended_at__lt=now - ALONE)
    for recording in gone.select_related("grant", "robot"):
        try:
            keeping.salvage(recording)
        except (OSError, ValueError):  # one bad file does not stop the cleaning
            log.exception("%s could not be finished", recording)
    for robot in Robot.objects.filter(recordings__state__in=SHOWN).distinct():
        removed += _clean_robot(robot, now)
    ages = settings.RECORDING["MOVIE_KEEP_DAYS"] * 86_400
    stay = {key for one in needed for key in one()}
    old = Movie.objects.filter(asked_at__gte=FIRST, asked_at__lt=now - timedelta(seconds=ages))
    removed += keeping.forget_movies(old.exclude(pk__in=stay))
    return removed + _clean_movies(stay) + _orphans()


def _clean_movies(stay: set[int]) -> int:
    """Remove the oldest movies if all together are too large, and files of movies that no row names."""
    removed, total = 0, 0
    for movie in Movie.objects.filter(state=Movie.State.READY).order_by("-ready_at", "-id"):
        total += movie.size
        if total > settings.RECORDING["MOVIES_MB"] * keeping.MB and movie.pk not in stay:
            removed += keeping.forget_movies([movie])
    paths = list((Path(settings.MEDIA_ROOT) / keeping.MOVIES).glob("*"))  # read before the rows, which are older
    ready = {keeping.movie_path(movie).name for movie in Movie.objects.filter(state=Movie.State.READY)}
    making = {str(pk) for pk in Movie.objects.filter(state=Movie.State.MAKING).values_list("pk", flat=True)}
    for path in paths:
        if path.name not in ready and path.name.partition(".")[0].partition("-")[0] not in making:
            removed += _unlinked(path)
    return removed


def _clean_robot(robot: Robot, now: datetime) -> int:
    days, removed = keep_days(robot), 0
    kept = Recording.objects.filter(robot=robot, state__in=SHOWN).order_by("began_at")
    for recording in kept:
        if (now - recording.began_at).days >= days and recording.began_at >= FIRST:
            removed += _removed(recording, f"Recordings are kept for {days} days.")
    limit = robot.recordings_limit_mb
    most = (settings.RECORDING["LIMIT_MB"] if limit is None else limit) * keeping.MB
    total = kept.aggregate(total=Sum("size"))["total"] or 0
    for recording in kept.all() if total > most else ():
        if total <= most:
            break
        total -= recording.size
        removed += _removed(recording, "Removed to make room for newer recordings.")
    return removed


def _removed(recording: Recording, reason: str) -> bool:
    try:
        return keeping.remove(recording, reason)
    except OSError:
        log.exception("the files of %s could not be removed", recording)
        return False


def _orphans() -> int:
    """Remove files that no row names: of a robot that was deleted, or of an interrupted write."""
    removed, media = 0, Path(settings.MEDIA_ROOT)
    paths = list((media / keeping.FOLDER).glob("*/*/*"))  # read before the rows, which are older than their files
    kept = Recording.objects.exclude(state=RecordingState.REMOVED)
    known = {Path(recording.file).with_suffix(""): recording for recording in kept}
    for path in paths:
        stem = path.with_suffix("").relative_to(media)
        if path.suffix == keeping.BUSY:
            stem = stem.with_name(stem.name.rpartition("-")[0])
        recording = known.get(stem)
        if recording is None:
            removed += _unlinked(path)
        elif path.suffix == keeping.BUSY:
            with contextlib.suppress(Recording.DoesNotExist), keeping.hold(recording):  # its writer holds it
                removed += _unlinked(path)
    for folder in (media / keeping.FOLDER).glob("*/*"):
        with contextlib.suppress(OSError):
            folder.rmdir()
    return removed


def _unlinked(path: Path) -> int:
    with contextlib.suppress(OSError):
        path.unlink()
        return 1
    return 0
