"""Reads the daily figures of the portal or of a robot, and what somebody asks for."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date, timedelta

from django.http import Http404, QueryDict
from django.utils.translation import gettext

from portal.web.daily.milestones import FIGURES, Day
from portal.web.daily.models import DailyFigures
from robots.models import Robot

SPANS = (30, 90, 365)  # days that a page shows
MOST_DAYS = 10_000  # rows that are read: 27 years
A_DAY = timedelta(days=1)
NAMES = tuple(figure.name for figure in FIGURES)


class BadSpan(ValueError):
    """Its text says what is wrong with what was asked for, and what to write."""


@dataclass(frozen=True)
class Selection:
    """The robot (None: the portal) and the days that are asked for, both included."""

    robot: Robot | None
    days: int
    until: date

    @property
    def since(self) -> date:
        """Return the first day."""
        return self.until - (self.days - 1) * A_DAY

    @property
    def name(self) -> str:
        """Return the name of what the figures are of."""
        return self.robot.full_name if self.robot else gettext("the whole portal")


def selection_of(query: QueryDict, today: date) -> Selection:
    """Return what the query of an address asks for. Raises BadSpan; Http404 for a robot that there is not."""
    days, until, slug = query.get("days", ""), query.get("until", ""), query.get("robot", "")
    if days not in ("", *map(str, SPANS)):
        raise BadSpan(gettext("Choose 30, 90 or 365 days."))
    try:
        last = date.fromisoformat(until) if until else today
    except ValueError as error:
        raise BadSpan(gettext("The last day is no date: write it as 2026-03-31.")) from error
    if not date(2000, 1, 1) <= last <= today:
        raise BadSpan(gettext("The last day has to be today or earlier, and after the year 1999."))
    robot = Robot.objects.filter(slug=slug).first() if slug else None
    if slug and robot is None:
        raise Http404("There is no such robot.")
    return Selection(robot, int(days or SPANS[0]), last)


def days_of(robot: Robot | None) -> list[Day]:
    """Return all days from the first that has figures, in order; those without a row have no values."""
    rows = DailyFigures.objects.filter(robot=robot).order_by("day").values("day", "addresses_whole", *NAMES)
    found: list[Day] = []
    for row in rows[:MOST_DAYS]:
        day, whole = row.pop("day"), row.pop("addresses_whole")
        while found and found[-1].day + A_DAY < day and len(found) < MOST_DAYS:
            found.append(Day(found[-1].day + A_DAY, {}))
        found.append(Day(day, row, whole))
    return found


def within(days: Sequence[Day], selection: Selection) -> list[Day]:
    """Return each day that is asked for; one without a row has no values."""
    known = {one.day: one for one in days}
    span = (selection.since + n * A_DAY for n in range(selection.days))
    return [known.get(day) or Day(day, {}) for day in span]
