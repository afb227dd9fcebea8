"""Computes the figures of a day that follow from other rows: turns, commands, log entries, finds, use."""

from collections import defaultdict
from datetime import UTC, date, datetime, time, timedelta
from typing import Any

from django.db.models import Count, Max, Min, Sum

from operatorlog.models import Entry, Find
from portal.web.daily.hits import change
from portal.web.daily.models import DailyFigures
from queueing.models import Turn
from robots.bus import web_uptime
from robots.models import Command, Robot, Usage
from robots.states import ASKED_FOR

A_DAY = timedelta(days=1)
LOOK_BACK = timedelta(days=400)  # as long as counters of use are kept
DAYS_AT_ONCE = 30  # of an installation that has none of these rows yet
LATE = 2  # days that are computed again, for what ends or is stored late
Numbers = dict[str, int | float]


def keep(now: datetime) -> int:
    """Compute the rows up to today that are missing or may have changed. Return for how many days.

    Days before the first row are computed too, the oldest first, some at a time.
    """
    today = now.date()
    first = _first_day(now)
    last = DailyFigures.objects.exclude(turns=None).filter(day__lte=today).aggregate(last=Max("day"))["last"]
    start = first if last is None else max(first, last - (LATE - 1) * A_DAY)
    days = [start + n * A_DAY for n in range((today - start).days + 1)][:DAYS_AT_ONCE]
    counted_since = Usage.objects.aggregate(first=Min("at"))["first"]
    for day in days:
        used = counted_since is not None and day >= counted_since.date()
        for robot, numbers in numbers_of(day, used).items():
            change(day, robot, **numbers)
    _count_finds_again(days, last)
    if web_uptime.up_since(now) < now:  # nobody came, which is a figure; while the web is away nobody counts
        rows = DailyFigures.objects.filter(day=today)
        rows.filter(hits=None).update(hits=0)
        rows.filter(hits=0, addresses=None).update(addresses=0)
    return len(days)


def _count_finds_again(days: list[date], last: date | None) -> None:
    """Count the finds of earlier days of which one was decided since, and of those that had no such figure."""
    since = _span((last or days[0]) - (LATE - 1) * A_DAY)[0]
    decided = {at.date() for at in Find.objects.filter(decided_at__gte=since).values_list("reported_at", flat=True)}
    rows = DailyFigures.objects.filter(day__lt=days[0])
    without = rows.filter(finds=None).exclude(turns=None).order_by("day").values_list("day", flat=True).distinct()
    for day in sorted(decided.union(without[:DAYS_AT_ONCE])):
        found, those = _finds(*_span(day)), rows.filter(day=day)
        those.exclude(robot=None).update(finds=0)
        for robot, number in found.items():
            those.filter(robot=robot).update(finds=number)
        those.filter(robot=None).update(finds=sum(found.values()))


def _span(day: date) -> tuple[datetime, datetime]:
    """Return when a day begins and ends."""
    start = datetime.combine(day, time(), UTC)
    return start, start + A_DAY


def _first_day(now: datetime) -> date:
    begun = (
        Turn.objects.aggregate(first=Min("started_at"))["first"],
        Usage.objects.aggregate(first=Min("at"))["first"],
        Entry.objects.aggregate(first=Min("written_at"))["first"],
    )
    earliest = min((one for one in begun if one is not None), default=now)
    return max(earliest, now - LOOK_BACK).date()


def numbers_of(day: date, used: bool = True) -> dict[int | None, Numbers]:
    """Return the figures of a day by the key of a robot, and by None those of the portal.

    `used`: the use of robots was counted that day, so a robot without a row of use was not online. Practice does not
    count.
    """
    span = _span(day)
    robots = Robot.objects.filter(practice_for=None).values_list("pk", flat=True)
    found: dict[int, Numbers] = {key: _none(used) for key in robots}
    _add(found, "turns", _counted(Turn.objects.filter(started_at__gte=span[0], started_at__lt=span[1])))
    _add(found, "entries", _counted(Entry.objects.filter(written_at__gte=span[0], written_at__lt=span[1])))
    _add(found, "finds", _finds(*span))
    _add(found, "commands", {key: _commands(key, *span) for key in found})
    usage = Usage.objects.filter(robot__in=found, at__gte=span[0], at__lt=span[1])
    if used:
        for row in usage.values("robot").annotate(s=Sum("online_s"), most=Max("watching"), sent=Sum("sent_bytes")):
            found[row["robot"]] |= {"online_s": row["s"], "watching": row["most"], "sent_bytes": row["sent"]}
    together: Numbers = defaultdict(int)
    for numbers in found.values():
        for name, value in numbers.items():
            together[name] += value
    if used:
        slots = usage.values("at").annotate(here=Sum("watching")).order_by("-here")
        together["watching"] = next((row["here"] for row in slots[:1]), 0)
    whole: dict[int | None, Numbers] = {None: _none(used) | dict(together)}
    return whole | dict(found.items())


def _none(used: bool) -> Numbers:
    counted: Numbers = {"turns": 0, "commands": 0, "entries": 0, "finds": 0}
    return counted | {"online_s": 0.0, "watching": 0, "sent_bytes": 0} if used else counted


def _counted(rows: Any) -> dict[int, int]:
    return dict(rows.order_by().values_list("robot").annotate(n=Count("pk")))


def _finds(start: datetime, end: datetime) -> dict[int, int]:
    """Return how many finds of these hours are confirmed, by robot."""
    rows = Find.objects.filter(reported_at__gte=start, reported_at__lt=end, state=Find.State.CONFIRMED)
    return dict(rows.order_by().values_list("round__robot").annotate(n=Count("pk")))


def _commands(robot: int, start: datetime, end: datetime) -> int:
    ended = Command.objects.filter(robot=robot, ended_at__gte=start, ended_at__lt=end, accepted_at__isnull=False)
    return ended.filter(grant__kind__in=ASKED_FOR).order_by().count()


def _add(found: dict[int, Numbers], name: str, numbers: dict[int, int]) -> None:
    for key, number in numbers.items():
        if key in found:
            found[key][name] = number
