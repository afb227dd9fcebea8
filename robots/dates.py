"""Days, times and lengths of time in words; days and times as the reader's language writes them."""

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


def length_words(seconds: float) -> str:
    """Return a length of time in words, such as "2 min 5 s"."""
    minutes, rest = divmod(round(max(0.0, seconds)), 60)
    return f"{minutes} min {rest} s" if minutes and rest else f"{minutes} min" if minutes else f"{rest} s"
