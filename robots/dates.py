"""Days and times in words, as the reader's language writes them."""

from datetime import date

from django.utils.formats import date_format
from django.utils.translation import pgettext


def date_words(at: date, kind: str = "day") -> str:
    """Return a day, or a time, in words. `kind`: `day`, `minute`, `second` or `time` (without its day)."""
    return date_format(at, _format(kind))


def _format(kind: str) -> str:
    if kind == "day":
        return pgettext("format of a date", "j F Y")
    if kind == "second":
        return pgettext("format of a date", "j F Y, H:i:s")
    return pgettext("format of a date", "j F Y, H:i") if kind == "minute" else pgettext("format of a date", "H:i:s")
