"""Rows and files of recordings: begin, finish and remove them, and take pictures out of them."""

import contextlib
import fcntl
import logging
import os
import secrets
import shutil
from collections.abc import Iterable, Iterator
from datetime import datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any

from django.conf import settings
from django.db import IntegrityError, connection, transaction
from django.db.models import F, Q

from robots.kit.clock import SYSTEM, ms_of
from robots.kit.files import beside
from robots.models import Grant, Movie, Recording, RecordingState, Records, Robot
from robots.models.recordings import SHOWN
from robots.states import ASKED_FOR

if TYPE_CHECKING:
    from robots.kit.recording.container import Message

log = logging.getLogger(__name__)
FOLDER, MOVIES = "recordings", "movies"  # beside the pictures
MB = 1_000_000
LIVE = ".tape"  # a file while it is recorded
BUSY = ".new"  # a file while it is written again
OLD = ".old"  # the file of a recorder that was killed, while it is copied
LATE_MS = 2000  # the camera's pictures within this time of a picture that is taken out are taken out too
MARGIN = timedelta(seconds=10)  # a recording may end this long after its grant, and its pictures may be this late
NOT_TAKEN_OUT = "A picture of it was taken down, and the file could not be written without it."


def path_of(recording: Recording) -> Path:
    """Return the path of a recording's file after the recording has ended."""
    return Path(settings.MEDIA_ROOT) / recording.file


def live_path(recording: Recording) -> Path:
    """Return the path of its file while it is recorded."""
    return path_of(recording).with_suffix(LIVE)


def movie_path(movie: Movie) -> Path:
    """Return the path of a movie's file after it is made."""
    return Path(settings.MEDIA_ROOT) / MOVIES / f"{movie.pk}.{movie.kind}"


def recorded(robot: Robot) -> bool:
    """Return whether turns and jobs of the robot are recorded."""
    return robot.records == Records.WORK


def slugs_recorded() -> list[str]:
    """Return the slugs of the robots whose turns and jobs are recorded."""
    return list(Robot.objects.filter(records=Records.WORK, enabled=True).values_list("slug", flat=True))


def to_record() -> list[Grant]:
    """Return the open grants of turns and jobs on robots that are recorded."""
    found = Grant.objects.filter(ended_at=None, kind__in=ASKED_FOR, robot__records=Records.WORK, robot__enabled=True)
    return list(found.select_related("robot"))


def begin(grant: Grant, host: str, now: datetime) -> Recording | None:
    """Return the row of a grant's recording for this host's recorder; None if another recorder has recorded it.

    A recording that this host's recorder had begun before it was killed goes on.
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
    """Return the unfinished recordings of this host's recorder whose grants have ended."""
    found = Recording.objects.filter(host=host, state=RecordingState.RUNNING, grant__ended_at__isnull=False)
    return list(found.select_related("grant", "robot"))


@contextlib.contextmanager
def hold(recording: Recording) -> Iterator[Recording]:
    """Lock a recording, so that nobody else changes its row and file; yield its present row."""
    if connection.features.has_select_for_update:
        with transaction.atomic():
            yield Recording.objects.select_for_update().get(pk=recording.pk)
        return
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):  # without the folder there is no file to lock
            folder = os.open(settings.MEDIA_ROOT, os.O_RDONLY)
            stack.callback(os.close, folder)
            fcntl.flock(folder, fcntl.LOCK_EX)
        yield Recording.objects.get(pk=recording.pk)


def finish(recording: Recording, state: RecordingState, reason: str, now: datetime, dropped: int = 0) -> None:
    """Store how a recording ended. Its file is at `path_of` by now, or there is none.

    Pictures that were taken down meanwhile are removed before anybody can see the file; if that fails, the file is
    deleted.
    """
    path = path_of(recording)
    with hold(recording) as row:
        if row.state == RecordingState.RUNNING:
            if row.taken_out and path.exists() and not _written_again(row):
                reason = NOT_TAKEN_OUT
            size = path.stat().st_size if path.exists() else 0
            done = Recording.objects.filter(pk=row.pk, state=RecordingState.RUNNING)
            state = state if size else RecordingState.REMOVED
            done.update(state=state, reason=reason[:200], ended_at=now, size=size, dropped=dropped)
    recording.refresh_from_db()


def salvage(recording: Recording) -> None:
    """Finish a recording whose recorder was killed and whose grant has ended, with the readable part of its file."""
    live, old = live_path(recording), path_of(recording).with_suffix(OLD)
    try:
        source = old if old.exists() else live  # beside an old file, the live one is an interrupted copy of it
        if source.exists():
            copy(source, path_of(recording))
            live.unlink(missing_ok=True)
            old.unlink(missing_ok=True)
    except (OSError, ValueError) as error:
        log.warning("%s is lost: %s", recording, error)
    ended = recording.grant.ended_at or recording.began_at
    finish(recording, RecordingState.CUT, "The recorder was interrupted.", ended)


def _dated(reason: str) -> str:
    """Return the reason for a removal with the day, as the recording's page shows it."""
    return f"{SYSTEM.now():%-d %B %Y}: {reason}"[:200]


def remove(recording: Recording, reason: str) -> bool:
    """Remove the file and all movies of a recording; the row says when and why. Return False if it was removed."""
    with transaction.atomic():
        changed = Recording.objects.filter(pk=recording.pk).exclude(state=RecordingState.REMOVED)
        if not changed.update(state=RecordingState.REMOVED, reason=_dated(reason), size=0, track={}):
            return False
    for suffix in (".mcap", LIVE, OLD, BUSY):
        path_of(recording).with_suffix(suffix).unlink(missing_ok=True)
    forget_movies(Movie.objects.filter(recording=recording))
    lapses = Movie.objects.filter(robot=recording.robot, day=recording.began_at.date())
    forget_movies([lapse for lapse in lapses if recording.pk in lapse.sources])
    recording.refresh_from_db()
    return True


def settle_restored(now: datetime) -> None:
    """Mark the recordings and movies whose files are not in the restored backup as removed."""
    Recording.objects.filter(state=RecordingState.RUNNING).update(
        state=RecordingState.REMOVED, ended_at=now, reason=_dated("It was being recorded when the backup was made.")
    )
    for recording in Recording.objects.filter(state__in=SHOWN):
        if not path_of(recording).exists():
            Recording.objects.filter(pk=recording.pk).update(
                state=RecordingState.REMOVED, size=0, reason=_dated("Its file was not in the backup.")
            )
    forget_movies(movie for movie in Movie.objects.filter(state=Movie.State.READY) if not movie_path(movie).exists())


def forget_movies(movies: Iterable[Movie]) -> int:
    """Remove movies with their files. Return how many."""
    count = 0
    for movie in movies:
        movie_path(movie).unlink(missing_ok=True)
        movie.delete()
        count += 1
    return count


def forget_lapses(grant: Grant) -> None:
    """Remove the time-lapses of all days from which the grant has recordings or stored pictures."""
    days = {at.date() for at in grant.frames.values_list("taken_at", flat=True)}
    days |= {at.date() for at in Recording.objects.filter(grant=grant).values_list("began_at", flat=True)}
    forget_movies(Movie.objects.filter(robot=grant.robot_id, day__in=days))


def take_out_pictures(robot: Robot, at: datetime, still: int, camera: int = 0) -> int:
    """Take a picture out of the robot's recordings and movies. Return the number of these recordings.

    Pictures of the same camera within two seconds are taken out too; for the still of a pose, all that show that pose.
    """
    at_ms = ms_of(at)
    span = {"from_ms": at_ms - LATE_MS, "to_ms": at_ms + LATE_MS, "camera": camera, "still": still}
    meant = _around(robot, at)
    meant += [one for one in _beginning_with(robot, at, still, camera) if one not in meant] if still else []
    for recording in meant:
        with hold(recording) as row:
            row.taken_out = [*row.taken_out, span]
            Recording.objects.filter(pk=row.pk).update(taken_out=row.taken_out)
            if row.replayable:
                _rewrite(row)
    changed = {recording.pk for recording in meant}
    lapses = Movie.objects.filter(robot=robot, day__isnull=False)
    forget_movies([one for one in lapses if one.day == at.date() or changed & set(one.sources)])
    return len(meant)


def _around(robot: Robot, at: datetime) -> list[Recording]:
    """Return the recordings that may have pictures of that time, with a margin, because they outlast their grants.

    A recording that ended before it began, because the time of day was set back, may have pictures of any time.
    """
    kept = Recording.objects.filter(robot=robot).exclude(state=RecordingState.REMOVED)
    then = Q(began_at__lte=at + MARGIN) & (Q(ended_at=None) | Q(ended_at__gte=at - MARGIN))
    return list(kept.filter(then | Q(ended_at__lt=F("began_at"))))


def _beginning_with(robot: Robot, at: datetime, still: int, camera: int) -> list[Recording]:
    """Return the later recordings at whose beginning the robot still showed that pose."""
    found = []
    later = Recording.objects.filter(robot=robot, began_at__gt=at).exclude(state=RecordingState.REMOVED)
    for recording in later.order_by("began_at"):
        first = _first_still(path_of(recording), camera) if recording.replayable else still
        if first == still:
            found.append(recording)
        elif first:
            break  # the robot showed another pose; the former one does not return
    return found


def _first_still(path: Path, camera: int) -> int:
    """Return the first stored picture that a file shows, 0 if none."""
    from robots.kit.recording import container, reading  # noqa: PLC0415 - see copy

    try:
        for message in reading.messages(path, [f"{container.CAMERA}{camera}"]):
            with contextlib.suppress(ValueError, TypeError, OverflowError):  # an unreadable message shows no picture
                if still := int(message.content().get("still", 0)):
                    return still
    except OSError:
        log.warning("%s cannot be read", path)  # so it cannot be replayed either
    return 0


def forget_names(keys: Iterable[int]) -> None:
    """Remove the handle of a deleted account from these recordings, into which an earlier version wrote it."""
    for recording in Recording.objects.filter(pk__in=list(keys)):
        with hold(recording) as row:
            if row.replayable and _names_somebody(path_of(row)):
                _rewrite(row)


def _names_somebody(path: Path) -> bool:
    from robots.kit.recording import container, reading  # noqa: PLC0415 - see copy

    try:
        return any(container.nameless(one) is not one for one in reading.messages(path, {container.COMMANDS}))
    except OSError:
        return False


def _rewrite(row: Recording) -> None:
    """Write the file of a locked recording again and raise its version; if that fails, remove the recording."""
    path = path_of(row)
    if not _written_again(row):
        remove(row, NOT_TAKEN_OUT)
        return
    shown = Recording.objects.filter(pk=row.pk, state__in=SHOWN)
    if not shown.update(version=F("version") + 1, size=path.stat().st_size):
        path.unlink(missing_ok=True)  # it was removed meanwhile
    forget_movies(Movie.objects.filter(recording=row))


def _written_again(row: Recording) -> bool:
    """Write a file without the pictures that were taken down. If that fails, delete the file and return False."""
    path = path_of(row)
    new = path.with_name(f"{path.stem}-{secrets.token_hex(4)}{BUSY}")
    try:
        with beside(path, new):
            copy(path, new, lambda message: not is_taken_out(message, row.taken_out))
    except (OSError, ValueError):
        log.exception("%s could not be written without what was taken down", row)
        path.unlink(missing_ok=True)
        return False
    return True


def copy(path: Path, new: Path, wanted: Any = lambda message: True) -> int:
    """Copy all readable messages that `wanted` accepts to a complete new file. Return how many. Raises OSError."""
    from robots.kit.recording import container, reading  # noqa: PLC0415 - the libraries of files; few processes need them

    count, tape = 0, container.Tape(new, reading.about(path))
    try:
        for part in reading.parts(path):
            for message in filter(wanted, part.messages):
                tape.copy(container.nameless(message))
                last, count = message.at_ns, count + 1
            if part.fault and count:  # the copy has no fault of its own, so an event in it tells what is missing
                tape.put(container.EVENTS, last, {"what": "fault", "text": part.fault, "level": "warning"})
        tape.close()
    except BaseException:
        tape.abandon()
        new.unlink(missing_ok=True)
        raise
    return count


def is_taken_out(message: "Message", spans: list[dict[str, Any]]) -> bool:
    """Return whether a message is a picture in one of the spans."""
    from robots.kit.recording import container  # noqa: PLC0415 - see copy

    if not message.topic.startswith(container.CAMERA):
        return False
    try:
        content = message.content()
        taken = container.taken_ms(content)
    except ValueError:
        return True  # a picture without a readable time is removed
    camera = message.topic.removeprefix(container.CAMERA)
    near = any(str(span["camera"]) == camera and span["from_ms"] <= taken <= span["to_ms"] for span in spans)
    return near or content.get("still") in {span["still"] for span in spans if span["still"]}


def room() -> bool:
    """Return whether the disk has room for recordings."""
    try:
        Path(settings.MEDIA_ROOT).mkdir(parents=True, exist_ok=True)  # a portal without cameras has none yet
        return shutil.disk_usage(settings.MEDIA_ROOT).free > int(settings.RECORDING["FREE_MB"]) * MB
    except OSError:
        return False
