"""What people are told of the stores: a database that is away, a disk that is full."""

import shutil

from django.conf import settings

LEAST_FREE = 2_000_000  # bytes; a picture takes 10 kB, a page of the database's log 4 MB
FULL = (
    "The server's disk is full: pictures and records may not be kept. "
    "Stop works, and nothing that was confirmed is lost; staff have to make room."
)
AWAY = "The database does not answer. Pictures and stop work; nothing else can be done until it is back."


def down_text(error: BaseException) -> str:
    """Return what a person is told of a database that does not work."""
    return FULL if "full" in str(error) or "No space" in str(error) else AWAY


def trouble() -> str:
    """Return what a banner says of the disk; empty where there is room."""
    try:
        room = min(shutil.disk_usage(folder).free for folder in (settings.VAR, settings.MEDIA_ROOT.parent))
    except OSError:
        return ""
    return FULL if room < LEAST_FREE else ""
