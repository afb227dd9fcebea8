"""The 24 hours of which somebody asks for statistics."""

from dataclasses import dataclass
from datetime import UTC, datetime, time, timedelta, tzinfo

from django.utils.dateparse import parse_date, parse_datetime
from django.utils.translation import gettext

DAY = timedelta(hours=24)
EARLIEST = datetime(2000, 1, 1, tzinfo=UTC)


class BadDate(ValueError):
    """Its text says what is wrong with the date and what to write."""


@dataclass(frozen=True)
class Span:
    """From `start` to `end` (UTC), of which `until` is past."""

    start: datetime
    end: datetime
    until: datetime

    @property
    def seconds(self) -> float:
        """Return how much of it is past (s)."""
        return max(0.0, (self.until - self.start).total_seconds())


def span_of(text: str, now: datetime, zone: tzinfo = UTC) -> Span:
    """Return the 24 hours from that date or date and time; those before `now` for an empty text.

    `zone`: that of a time that names none.

    Raises:
        BadDate: no date, or one outside the years that can have statistics.
    """
    start = _start(text.strip(), zone) if text.strip() else now - DAY
    if start < EARLIEST:
        raise BadDate(gettext("There was no robot on this portal at that time; choose a later one."))
    if start > now:
        raise BadDate(gettext("This time has not come yet; choose an earlier one."))
    return Span(start, start + DAY, min(start + DAY, now))


def _start(text: str, zone: tzinfo) -> datetime:
    try:
        found = parse_datetime(text)
        if found is None:
            day = parse_date(text)
            found = datetime.combine(day, time()) if day is not None else None
        if found is None:
            raise _no_date()
        return (found.replace(tzinfo=zone) if found.tzinfo is None else found).astimezone(UTC)
    except (ValueError, OverflowError) as error:
        raise _no_date() from error


def _no_date() -> BadDate:
    return BadDate(gettext("This is no date and time: write it as 2026-03-31 or 2026-03-31T18:30Z, which is in UTC."))
