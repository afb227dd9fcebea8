"""The sentences for people when the database is away or the disk is full."""

import shutil

from django.conf import settings

LEAST_FREE = 2_000_000  # bytes; a picture takes 10 kB, a page of the database's log 4 MB
FULL = (
    "The server's disk is full: new pictures and records may be lost. "
    "Stop works, and nothing that was confirmed is lost. Staff have to free space on the disk."
)
AWAY = "The database does not answer. Pictures and Stop work; everything else has to wait until it is back."


def down_text(error: BaseException) -> str:
    """Return the sentence for a database that does not work."""
    return FULL if "full" in str(error) or "No space" in str(error) else AWAY


def trouble() -> str:
    """Return the sentence for a full disk; empty if there is room."""
    try:
        room = min(shutil.disk_usage(folder).free for folder in (settings.VAR, settings.MEDIA_ROOT.parent))
    except OSError:
        return ""
    return FULL if room < LEAST_FREE else ""
