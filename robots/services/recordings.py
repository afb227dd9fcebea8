"""Verbs of staff on pictures and recordings: take them off the portal, choose the movie of the day."""

from pathlib import Path
from typing import Any

from django.conf import settings
from django.db import transaction

from robots import bus
from robots.kit.clock import SYSTEM, ms_of
from robots.kit.packets import TAKEN_DOWN, Changed
from robots.models import Frame, Movie, Recording
from robots.models.recordings import OfTheDay
from robots.recordings import keeping, movies
from robots.services.permissions import need_staff


def take_down(frame: Frame, user: Any) -> int:
    """Remove a stored picture from log entries, recordings, movies and our addresses. Return how many recordings.

    Recordings also lose the pictures that show the same pose, and those that the camera took within two seconds of it.
    Live pictures of these seconds, which have an address for a minute, are removed as well.

    Raises:
        NotStaff: the person is not staff.
        OSError: a recording cannot be written again; the picture stays.
    """
    need_staff(user)
    robot, at = frame.robot, frame.taken_at
    changed = keeping.take_out_pictures(robot, at, frame.pk)
    (Path(settings.MEDIA_ROOT) / frame.file).unlink(missing_ok=True)
    bus.drop_shots(robot.slug, 0, ms_of(at), keeping.LATE_MS)
    with transaction.atomic():
        frame.delete()
        for event in (TAKEN_DOWN, Changed("log")):
            bus.publish_on_commit(robot.slug, event)
    return changed


def remove_recording(recording: Recording, user: Any) -> bool:
    """Remove a recording's file and its movies. Return False if that was done before. Raises NotStaff."""
    need_staff(user)
    return keeping.remove(recording, "Staff removed it.")


def choose_of_the_day(recording: Recording, choice: OfTheDay, user: Any) -> bool:
    """Set whether a recording's movie is the movie of the day, never is, or follows the rule.

    At most one recording is pinned; if it has no MP4 movie, one is made. Return False if the choice is set already.
    Raises NotStaff; BadRequest if there is nothing to pin.
    """
    need_staff(user)
    with transaction.atomic():
        if choice == OfTheDay.PINNED:
            movies.ask(recording, Movie.Kind.MP4, SYSTEM.now())
            others = Recording.objects.filter(of_the_day=OfTheDay.PINNED).exclude(pk=recording.pk)
            others.update(of_the_day=OfTheDay.BY_RULE)
        changed = Recording.objects.filter(pk=recording.pk).exclude(of_the_day=choice).update(of_the_day=choice)
    return bool(changed)
