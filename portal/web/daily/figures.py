"""Computes the figures of a day that follow from other rows: turns, waits, commands, entries, finds, use, faults."""

from collections import defaultdict
from collections.abc import Collection, Iterable
from datetime import UTC, date, datetime, time, timedelta
from statistics import median
from typing import Any

from django.db.models import Count, Max, Min, Q, Sum

from operatorlog.models import Entry, Find
from portal.web.daily.hits import change
from portal.web.daily.models import DailyFigures
from queueing.models import Turn
from robots.bus import web_uptime
from robots.models import Command, Incident, Robot, Usage
from robots.services.outages import CODE as OUTAGE
from robots.states import ASKED_FOR, CommandState

A_DAY = timedelta(days=1)
LOOK_BACK = timedelta(days=400)  # as long as counters of use are kept
DAYS_AT_ONCE = 30  # of an installation that has none of these rows yet
LATE = 2  # days that are computed again, for what ends or is stored late
Numbers = dict[str, int | float | None]
LATER = ("finds", "wait_median_s", "wait_longest_s", "success", "faults", "outages")  # figures that came later
UNDONE = (CommandState.FAILED, CommandState.REJECTED, CommandState.EXPIRED, CommandState.UNKNOWN)


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
    _count_again(days, last)
    if web_uptime.up_since(now) < now:  # nobody came, which is a figure; while the web is away nobody counts
        rows = DailyFigures.objects.filter(day=today)
        rows.filter(hits=None).update(hits=0)
        rows.filter(hits=0, addresses=None).update(addresses=0)
    return len(days)


def _count_again(days: list[date], last: date | None) -> None:
    """Count the finds of earlier days of which one was decided since, and the figures that came later.

    What else is known of these days stays.
    """
    since = _span((last or days[0]) - (LATE - 1) * A_DAY)[0]
    decided = {at.date() for at in Find.objects.filter(decided_at__gte=since).values_list("reported_at", flat=True)}
    rows = DailyFigures.objects.filter(day__lt=days[0])
    lacking = rows.filter(Q(finds=None) | Q(faults=None), robot__practice_for=None).exclude(turns=None)
    without = lacking.order_by("day").values_list("day", flat=True).distinct()[:DAYS_AT_ONCE]
    for names, which in (LATER[:1], decided.difference(without)), (LATER, without):
        for day in which:
            for robot, numbers in numbers_of(day, False).items():
                rows.filter(day=day, robot=robot).update(**{name: numbers[name] for name in names})


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
    found: dict[int, dict[str, int | float]] = {key: _none(used) for key in robots}
    _add(found, "turns", _counted(Turn.objects.filter(started_at__gte=span[0], started_at__lt=span[1])))
    _add(found, "entries", _counted(Entry.objects.filter(written_at__gte=span[0], written_at__lt=span[1])))
    _add(found, "finds", _finds(*span))
    noted = Incident.objects.filter(at__gte=span[0], at__lt=span[1])
    _add(found, "faults", _counted(noted.exclude(code=OUTAGE)))
    _add(found, "outages", _counted(noted.filter(code=OUTAGE)))
    ended = {key: _commands(key, *span) for key in found}
    _add(found, "commands", {key: sum(counts) for key, counts in ended.items()})
    usage = Usage.objects.filter(robot__in=found, at__gte=span[0], at__lt=span[1])
    if used:
        for row in usage.values("robot").annotate(s=Sum("online_s"), most=Max("watching"), sent=Sum("sent_bytes")):
            found[row["robot"]] |= {"online_s": row["s"], "watching": row["most"], "sent_bytes": row["sent"]}
    together: dict[str, int | float] = defaultdict(int)
    for numbers in found.values():
        for name, value in numbers.items():
            together[name] += value
    if used:
        slots = usage.values("at").annotate(here=Sum("watching")).order_by("-here")
        together["watching"] = next((row["here"] for row in slots[:1]), 0)
    waits = _waits(found, *span)
    whole: dict[int | None, Numbers] = {
        None: {**_none(used), **together, **_shares(ended.values(), [one for some in waits.values() for one in some])}
    }
    return whole | {key: {**found[key], **_shares([ended[key]], waits[key])} for key in found}


def _none(used: bool) -> dict[str, int | float]:
    counted: dict[str, int | float] = dict.fromkeys(("turns", "commands", "entries", "finds", "faults", "outages"), 0)
    return counted | {"online_s": 0.0, "watching": 0, "sent_bytes": 0} if used else counted


def _shares(ended: Collection[tuple[int, int, int]], waits: list[float]) -> Numbers:
    """Return the figures that do not add up, of what `_commands` and `_waits` have found; None where there is none."""
    good, bad = (sum(counts[n] for counts in ended) for n in (0, 1))
    return {
        "success": good / (good + bad) if good + bad else None,
        "wait_median_s": median(waits) if waits else None,
        "wait_longest_s": max(waits, default=None),
    }


def _waits(robots: Iterable[int], start: datetime, end: datetime) -> dict[int, list[float]]:
    """Return how long people had waited for the turns that began in these hours (s), by robot.

    Of a deleted account nobody knows it.
    """
    found: dict[int, list[float]] = {key: [] for key in robots}
    begun = Turn.objects.filter(started_at__gte=start, started_at__lt=end, ticket__isnull=False, robot__in=found)
    for robot, joined, started in begun.values_list("robot", "ticket__joined_at", "started_at"):
        found[robot].append(max(0.0, (started - joined).total_seconds()))
    return found


def _counted(rows: Any) -> dict[int, int]:
    return dict(rows.order_by().values_list("robot").annotate(n=Count("pk")))


def _finds(start: datetime, end: datetime) -> dict[int, int]:
    """Return how many finds of these hours are confirmed, by robot."""
    rows = Find.objects.filter(reported_at__gte=start, reported_at__lt=end, state=Find.State.CONFIRMED)
    return dict(rows.order_by().values_list("round__robot").annotate(n=Count("pk")))


def _commands(robot: int, start: datetime, end: datetime) -> tuple[int, int, int]:
    """Return how many commands of people ended in these hours: carried out, not carried out, ended before by people."""
    ended = Command.objects.filter(robot=robot, ended_at__gte=start, ended_at__lt=end, accepted_at__isnull=False)
    counts = ended.filter(grant__kind__in=ASKED_FOR).order_by().aggregate(
        good=Count("pk", filter=Q(state=CommandState.COMPLETED)), bad=Count("pk", filter=Q(state__in=UNDONE)),
        all=Count("pk"),
    )  # fmt: skip
    return counts["good"], counts["bad"], counts["all"] - counts["good"] - counts["bad"]


def _add(found: dict[int, dict[str, int | float]], name: str, numbers: dict[int, int]) -> None:
    for key, number in numbers.items():
        if key in found:
            found[key][name] = number
