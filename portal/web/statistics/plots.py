"""The plots of a page of statistics, in the units of their SVG: left 60, bottom 206, 640 wide."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from datetime import date, datetime, timedelta
from decimal import Decimal
from math import floor, isfinite, log10

from django.utils.formats import date_format, number_format
from django.utils.timezone import localtime
from django.utils.translation import gettext, pgettext

from portal.web.statistics.counting import Bin, round_step

LEFT, RIGHT, TOP, BOTTOM = 60.0, 634.0, 26.0, 206.0
DATES = 6  # at the axis
UNKNOWN = 5.0  # height of what says that a number is not known
BELOW = 32.0  # so that on a phone, whose letters are larger here, the first time of day is clear of the least number


@dataclass(frozen=True)
class Bar:
    """One bar: its place, its class, and its meaning in words."""

    x: float
    y: float
    width: float
    height: float
    css: str
    title: str


@dataclass(frozen=True)
class Mark:
    """A number at an axis."""

    x: float
    y: float
    text: str


@dataclass(frozen=True)
class Plot:
    """Bars or a line, with marks at both axes."""

    bars: tuple[Bar, ...]
    line: str
    across: tuple[Mark, ...]
    up: tuple[Mark, ...]
    tops: tuple[Mark, ...] = ()
    flags: tuple[Mark, ...] = ()


def short(value: float) -> str:
    """Return a number as short as beside an axis: 7.9, 250, 2.5k, 10M."""
    for size, unit in ((1e6, "M"), (1e3, "k")):
        if abs(value) >= size:
            return f"{_digits(value / size)}{unit}"
    return _digits(value)


def _digits(value: float, form: str = ".3g") -> str:
    """Return a number as the reader's language has it."""
    return str(number_format(Decimal(f"{value:{form}}")))


def clock_of(start: datetime, hour: int) -> str:
    """Return the time of day so many hours after `start`, in the reader's zone."""
    return f"{localtime(start + timedelta(hours=hour)):%H:%M}"


def hours(counts: list[tuple[int, int]], start: datetime, job: str, jobs: str, done: str) -> Plot:
    """Return jobs asked for in each hour from `start`, with those done in front."""
    most = max([asked for asked, _ in counts] + [1])
    step = max(1.0, round_step(0.0, most * 2.4))
    top = step * -(-most // step)
    wide = (RIGHT - LEFT) / len(counts)
    bars, across = [], []
    for n, (asked, reached) in enumerate(counts):
        for count, css in ((asked, "asked"), (reached, "done")):
            high = (BOTTOM - TOP) * count / top
            words = gettext("from {time}: {asked} {jobs}, {reached} {done}").format(
                time=clock_of(start, n), asked=asked, jobs=job if asked == 1 else jobs, reached=reached, done=done
            )
            bars.append(Bar(LEFT + n * wide + 2, BOTTOM - high, wide - 4, high, css, words))
        if n % 4 == 0:
            across.append(Mark(LEFT + (n + 0.5) * wide, BOTTOM + BELOW, clock_of(start, n)))
    return Plot(tuple(bars), "", tuple(across), _up(0.0, top, step))


def success(bins: list[Bin], done: str) -> Plot:
    """Return the share of jobs that are done against a channel's value."""
    wide = (RIGHT - LEFT) / max(len(bins), 1)
    bars, across, tops = [], [], []
    for n, one in enumerate(bins):
        share = one.done / one.attempted if one.attempted else 0.0
        high, x = (BOTTOM - TOP) * share, LEFT + n * wide
        words = gettext("{low} to {high}: {reached} of {attempted} {done}").format(
            low=_digits(one.low, "g"), high=_digits(one.high, "g"), reached=one.done, attempted=one.attempted, done=done
        )
        bars.append(Bar(x + 3, BOTTOM - high, wide - 6, high, "done", words))
        if one.attempted:
            tops.append(Mark(x + wide / 2, BOTTOM - high - 6, f"{100 * share:.0f}"))
        across.append(Mark(x + wide / 2, BOTTOM + BELOW, short(one.low)))
    return Plot(tuple(bars), "", tuple(across), _up(0.0, 100.0, 25.0), tuple(tops))


def line(points: list[tuple[float, float]], low: float, high: float, start: datetime) -> Plot:
    """Return the course of a channel over 24 hours, as a line between `low` and `high`."""
    span = high - low
    inside = [(h, min(max(v, low), high)) for h, v in points if isfinite(v)] if 0 < span < float("inf") else []
    drawn = " ".join(f"{_across(h):.1f},{BOTTOM - (BOTTOM - TOP) * (v - low) / span:.1f}" for h, v in inside)
    marks = tuple(Mark(_across(h), BOTTOM + BELOW, clock_of(start, h)) for h in range(0, 24, 4))
    return Plot((), drawn, marks, _up(low, high, span / 4) if inside else ())


def days(values: Sequence[tuple[date, float | None, str]], marked: Collection[date]) -> Plot:
    """Return a number for each day, with its meaning in words; None: not known, which is drawn below the axis.

    Days that are `marked` have a flag, counted from 1.
    """
    most = max([value for _, value, _ in values if value is not None] + [0.0])
    step = 10.0 ** floor(log10(max(most, 0.01) / 4)) if most > 0 else 0.25
    step = next(step * factor for factor in (1.0, 2.0, 2.5, 5.0, 10.0) if most <= 4 * step * factor)
    top, wide, every = 4 * step, (RIGHT - LEFT) / len(values), -(-len(values) // DATES)
    bars, across = [], []
    flags: list[Mark] = []
    form = pgettext("format of a date", "j M Y")
    for n, (day, value, words) in enumerate(values):
        x, high = LEFT + n * wide, (BOTTOM - TOP) * (value or 0.0) / top
        y, css = (BOTTOM - high, "done") if value is not None else (BOTTOM, "unknown")
        bars.append(
            Bar(
                x + 0.1 * wide,
                y,
                0.8 * wide,
                high if value is not None else UNKNOWN,
                css,
                f"{date_format(day, form)}: {words}",
            )
        )
        if n % every == 0:
            across.append(Mark(x + wide / 2, BOTTOM + BELOW, date_format(day, pgettext("format of a date", "j M"))))
        if day in marked:
            flags.append(Mark(x + wide / 2, TOP - 8, str(len(flags) + 1)))
    return Plot(tuple(bars), "", tuple(across), _up(0.0, top, step), flags=tuple(flags))


def _across(hour: float) -> float:
    return LEFT + (RIGHT - LEFT) * hour / 24.0


def _up(low: float, high: float, step: float) -> tuple[Mark, ...]:
    return tuple(
        Mark(LEFT - 8, BOTTOM - (BOTTOM - TOP) * n * step / (high - low), short(low + n * step))
        for n in range(round((high - low) / step) + 1)
    )
