"""Stored pictures in lists of the admin."""

from django.utils.html import format_html
from django.utils.safestring import SafeString

from robots.models import Frame


def thumbnail(frame: Frame | None, words: str) -> SafeString | str:
    """Return a small picture that leads to the whole one, loaded when it is scrolled to; a dash without one."""
    if frame is None:
        return "-"
    return format_html(
        '<a href="{0}"><img class="farhand-thumbnail" src="{0}" alt="{1}" loading="lazy"></a>', frame.url, words
    )
