"""Removes old pictures that nothing refers to, and sessions that ran out."""

import shutil
from datetime import datetime, timedelta
from pathlib import Path

from django.conf import settings
from django.contrib.sessions.models import Session

from robots.models import Frame
from robots.wall_clock import FIRST


def old_frames(now: datetime) -> int:
    """Remove old pictures with their files and empty folders. Return how many."""
    before = now - timedelta(days=settings.FRAME_KEEP_DAYS)
    removed = 0
    for frame in Frame.objects.filter(taken_at__gte=FIRST, taken_at__lt=before, kept=False).iterator():
        (Path(settings.MEDIA_ROOT) / frame.file).unlink(missing_ok=True)
        frame.delete()
        removed += 1
    for folder in Path(settings.MEDIA_ROOT).glob("frames/*/*"):
        if folder.is_dir() and not any(folder.iterdir()):
            shutil.rmtree(folder, ignore_errors=True)
    return removed


def old_sessions(now: datetime) -> int:
    """Remove the rows of sessions that ran out; nobody can use them any more. Return how many."""
    return Session.objects.filter(expire_date__lt=now).delete()[0]
