"""Rows and files of recordings: begun, finished, removed, and pictures taken out of them."""

import contextlib
import logging
import shutil
from collections.abc import Iterable
from datetime import datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any

from django.conf import settings
from django.db import IntegrityError, transaction
from django.db.models import Q, Sum

from robots.models import Grant, Movie, Recording, RecordingState, Records, Robot
from robots.recordings.models import SHOWN, keep_days
from robots.states import GrantKind

if TYPE_CHECKING:
    from robots.recordings.container import Message

log = logging.getLogger(__name__)
FOLDER, MOVIES = "recordings", "movies"  # beside the pictures
MB = 1_000_000
RECORDED = (GrantKind.TURN, GrantKind.JOB)
LIVE = ".tape"  # while it is written
BUSY = ".new"  # while it is written again
OLD = ".old"  # what a recorder that was killed has left, while it is copied
ALONE = timedelta(hours=1)  # after which nobody waits for a recorder any more that has not finished
LATE_MS = 2000  # around a picture that is taken out, as much is taken out of the camera's other pictures


def path_of(recording: Recording) -> Path:
    """Return its file."""
    return Path(settings.MEDIA_ROOT) / recording.file


def live_path(recording: Recording) -> Path:
    """Return the file while it is recorded."""
    return path_of(recording).with_suffix(LIVE)


def movie_path(movie: Movie) -> Path:
    """Return the file of a movie."""
    return Path(settings.MEDIA_ROOT) / MOVIES / f"{movie.pk}.{movie.kind}"


def recorded(robot: Robot) -> bool:
    """Return whether turns and jobs of the robot are recorded."""
    return robot.records == Records.WORK


def slugs_recorded() -> list[str]:
    """Return the slugs of the robots whose turns and jobs are recorded."""
    return list(Robot.objects.filter(records=Records.WORK, enabled=True).values_list("slug", flat=True))


def to_record() -> list[Grant]:
    """Return the open grants of turns and jobs on robots that are recorded."""
    found = Grant.objects.filter(ended_at=None, kind__in=RECORDED, robot__records=Records.WORK, robot__enabled=True)
    return list(found.select_related("robot"))


def begin(grant: Grant, host: str, now: datetime) -> Recording | None:
    """Return the row of a grant's recording for this host's recorder; None if it is or was recorded already.

    A recording that this host's recorder had begun when it was killed goes on.
    """
    slug = grant.robot.slug
    row = Recording(robot=grant.robot, grant=grant, began_at=now, host=host)
    row.file = f"{FOLDER}/{slug}/{now:%Y%m%d}/{now:%H%M%S}-{row.key[:12]}.mcap"
    try:
        with transaction.atomic():
            row.save()
    except IntegrityError:
        return Recording.objects.filter(grant=grant, host=host, state=RecordingState.RUNNING).first()
    return row


def left_by(host: str) -> list[Recording]:
    """Return the recordings that this host's recorder began and did not finish, of grants that have ended."""
    found = Recording.objects.filter(host=host, state=RecordingState.RUNNING, grant__ended_at__isnull=False)
    return list(found.select_related("grant", "robot"))


def finish(recording: Recording, state: RecordingState, reason: str, now: datetime, dropped: int = 0) -> None:
    """Note how a recording ended. Its file is in its place by now, or there is none."""
    path = path_of(recording)
    size = path.stat().st_size if path.exists() else 0
    if not size:
        state = RecordingState.REMOVED
    done = Recording.objects.filter(pk=recording.pk, state=RecordingState.RUNNING)
    done.update(state=state, reason=reason[:200], ended_at=now, size=size, dropped=dropped)
    recording.refresh_from_db()
    if recording.taken_out and recording.shown:
        _rewrite(recording, recording.taken_out)


def salvage(recording: Recording) -> None:
    """Finish a recording whose recorder was killed and whose grant has ended, with all that can be read of its file."""
    live = live_path(recording)
    try:
        if live.exists():
            copy(live, path_of(recording))
            live.unlink()
    except (OSError, ValueError) as error:
        log.warning("%s is lost: %s", recording, error)
    ended = recording.grant.ended_at or recording.began_at
    finish(recording, RecordingState.CUT, "The recorder was interrupted.", ended)


def remove(recording: Recording, reason: str) -> bool:
    """Remove the file and all movies of a recording; the row stays and says why. Return False if that was done."""
    with transaction.atomic():
        changed = Recording.objects.filter(pk=recording.pk).exclude(state=RecordingState.REMOVED)
        if not changed.update(state=RecordingState.REMOVED, reason=reason[:200], size=0):
            return False
    for path in (path_of(recording), live_path(recording)):
        path.unlink(missing_ok=True)
    forget_movies(Movie.objects.filter(recording=recording))
    recording.refresh_from_db()
    return True


def settle_restored(now: datetime) -> None:
    """After a restore: what was being recorded, or whose file was left out of the backup, has no file."""
    Recording.objects.filter(state=RecordingState.RUNNING).update(
        state=RecordingState.REMOVED, ended_at=now, reason="It was being recorded when the backup was made."
    )
    for recording in Recording.objects.filter(state__in=SHOWN):
        if not path_of(recording).exists():
            Recording.objects.filter(pk=recording.pk).update(
                state=RecordingState.REMOVED, size=0, reason="Its file was not in the backup."
            )


def forget_movies(movies: Iterable[Movie]) -> int:
    """Remove movies with their files. Return how many."""
    count = 0
    for movie in movies:
        movie_path(movie).unlink(missing_ok=True)
        movie.delete()
        count += 1
    return count


def take_out_pictures(robot: Robot, at: datetime, still: int, camera: int = 0) -> int:
    """Take a picture out of the robot's recordings and movies. Return of how many recordings.

    What the camera showed within two seconds of it goes too; for the still of a pose, everything that shows that pose.
    """
    at_ms = int(at.timestamp() * 1000)
    span = {"from_ms": at_ms - LATE_MS, "to_ms": at_ms + LATE_MS, "camera": camera, "still": still}
    meant = Recording.objects.filter(robot=robot, began_at__lte=at).filter(Q(ended_at=None) | Q(ended_at__gte=at))
    count = 0
    for recording in meant.exclude(state=RecordingState.REMOVED):
        count += 1
        with transaction.atomic():
            row = Recording.objects.select_for_update().get(pk=recording.pk)
            row.taken_out = [*row.taken_out, span]
            row.save(update_fields=["taken_out"])
        if row.shown:
            _rewrite(row, [span])
    forget_movies(Movie.objects.filter(robot=robot, day=at.date()))
    return count


def _rewrite(recording: Recording, spans: list[dict[str, Any]]) -> None:
    """Write the file again without some pictures, under a new version of its addresses."""
    path, new = path_of(recording), path_of(recording).with_suffix(BUSY)
    copy(path, new, lambda message: not taken_out(message, spans))
    new.replace(path)
    Recording.objects.filter(pk=recording.pk).update(version=recording.version + 1, size=path.stat().st_size)
    forget_movies(Movie.objects.filter(recording=recording))
    recording.refresh_from_db()


def copy(path: Path, new: Path, wanted: Any = lambda message: True) -> int:
    """Copy the messages that `wanted` accepts to a whole new file. Return how many. Raises OSError, ValueError."""
    from robots.recordings import container  # noqa: PLC0415 - the libraries of files; few processes need them

    count, tape = 0, container.Tape(new, container.about(path))
    try:
        for message in container.messages(path):
            if wanted(message):
                tape.copy(message)
                count += 1
        tape.close()
    except BaseException:
        tape.abandon()
        new.unlink(missing_ok=True)
        raise
    return count


def taken_out(message: "Message", spans: list[dict[str, Any]]) -> bool:
    """Return whether a message is a picture in one of the spans."""
    from robots.recordings import container  # noqa: PLC0415 - see copy

    if not message.topic.startswith(container.CAMERA):
        return False
    try:
        told = message.told()
        taken = container.taken_ms(told)
    except ValueError:
        return True  # what cannot be judged goes
    camera = message.topic.removeprefix(container.CAMERA)
    near = any(str(span["camera"]) == camera and span["from_ms"] <= taken <= span["to_ms"] for span in spans)
    return near or told.get("still") in {span["still"] for span in spans if span["still"]}


def room() -> bool:
    """Return whether the disk has room for recordings."""
    try:
        Path(settings.MEDIA_ROOT).mkdir(parents=True, exist_ok=True)  # a portal without cameras has none yet
        return shutil.disk_usage(settings.MEDIA_ROOT).free > int(settings.RECORDING["FREE_MB"]) * MB
    except OSError:
        return False


def clean(now: datetime) -> int:
    """Remove recordings that are too old, or the oldest where a robot has too many; old movies; and files of nobody.

    Return how many.
    """
    removed = 0
    gone = Recording.objects.filter(state=RecordingState.RUNNING, grant__ended_at__lt=now - ALONE)
    for recording in gone.select_related("grant", "robot"):
        salvage(recording)
    for robot in Robot.objects.filter(recordings__state__in=SHOWN).distinct():
        removed += _clean_robot(robot, now)
    ages = settings.RECORDING["MOVIE_KEEP_DAYS"] * 86_400
    removed += forget_movies([m for m in Movie.objects.all() if (now - m.asked_at).total_seconds() > ages])
    return removed + _unknown_files(now)


def _clean_robot(robot: Robot, now: datetime) -> int:
    days, removed = keep_days(robot), 0
    kept = Recording.objects.filter(robot=robot, state__in=SHOWN).order_by("began_at")
    for recording in kept:
        if (now - recording.began_at).days >= days:
            removed += remove(recording, f"Recordings are kept for {days} days.")
    limit = robot.recordings_limit_mb
    most = (settings.RECORDING["LIMIT_MB"] if limit is None else limit) * MB
    total = kept.aggregate(total=Sum("size"))["total"] or 0
    for recording in kept.all() if total > most else ():
        if total <= most:
            break
        total -= recording.size
        removed += remove(recording, "Removed to make room for newer recordings.")
    return removed


def _unknown_files(now: datetime) -> int:
    """Remove files that no row names: of a robot that was deleted, or of a write that was cut off."""
    removed, media = 0, Path(settings.MEDIA_ROOT)
    known = set(Recording.objects.exclude(state=RecordingState.REMOVED).values_list("file", flat=True))
    for path in (media / FOLDER).glob("*/*/*"):
        name = str(path.with_suffix(".mcap").relative_to(media))
        with contextlib.suppress(OSError):
            old = now.timestamp() - path.stat().st_mtime > 3600
            if old and (name not in known or path.suffix == BUSY):
                path.unlink()
                removed += 1
    for folder in (media / FOLDER).glob("*/*"):
        with contextlib.suppress(OSError):
            folder.rmdir()
    return removed
