"""Counts jobs and motions. Pure: no database, no clock."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from math import floor, log10

REACHED, GAVE_UP, FAULT, UNKNOWN = "done", "gave_up", "fault", "unknown"
REFUSED, CANCELLED, OPEN = "refused", "cancelled", "open"
ATTEMPTED = (REACHED, GAVE_UP, FAULT, UNKNOWN)
MOST_BINS, MOST_POINTS = 12, 288
HOURS = 24


@dataclass(frozen=True)
class Ask:
    """A job: when it was asked for, how it ended (one of the words above, or the robot's own code), by whom.

    `value` is that of the channel against which success is drawn, when the job began; None where it is not known.
    """

    at: datetime
    outcome: str
    asker: str = ""
    value: float | None = None


@dataclass(frozen=True)
class Motion:
    """A motion, and the values of channels at its beginning and its end."""

    kind: str
    state: str
    began_at: datetime
    ended_at: datetime
    first: Mapping[str, float] = field(default_factory=dict)
    last: Mapping[str, float] = field(default_factory=dict)


def growth(readings: Iterable[float], before: float | None = None) -> float | None:
    """Return by how much a counter grew from the reading `before` over these; None where nothing was read.

    A counter that fell has begun again at zero, so its whole value counts.
    """
    total, last, any_read = 0.0, before, False
    for value in readings:
        any_read = True
        if last is not None:
            total += value - last if value >= last else max(value, 0.0)
        last = value
    return total if any_read else None


def readings(motions: Iterable[Motion], channel: str) -> list[float]:
    """Return the readings of a channel, in the order of time."""
    told = (value.get(channel) for motion in motions for value in (motion.first, motion.last))
    return [value for value in told if value is not None]


def seconds_of(motions: Iterable[Motion], kinds: Sequence[str], start: datetime, end: datetime) -> float:
    """Return how long motions of these kinds ran between two times (s)."""
    parts = (min(m.ended_at, end) - max(m.began_at, start) for m in motions if m.kind in kinds)
    return sum((part for part in parts if part > timedelta()), timedelta()).total_seconds()


def outcomes(asks: Iterable[Ask]) -> Counter[str]:
    """Return how many jobs ended in which way."""
    return Counter(ask.outcome for ask in asks)


def attempted(counts: Mapping[str, int]) -> int:
    """Return how many jobs the robot began and that are over, without those that were cancelled."""
    return sum(counts.get(outcome, 0) for outcome in ATTEMPTED)


def by_hour(asks: Iterable[Ask], start: datetime) -> list[tuple[int, int]]:
    """Return for each of 24 hours from `start` how many jobs were asked for in it, and how many of these are done."""
    hours = [(0, 0)] * HOURS
    for ask in asks:
        hour = (ask.at - start) // timedelta(hours=1)
        if 0 <= hour < HOURS:
            asked, done = hours[hour]
            hours[hour] = asked + 1, done + (ask.outcome == REACHED)
    return hours


@dataclass(frozen=True)
class Bin:
    """The number of jobs that began while a channel was between `low` and `high`, and how many of them are done."""

    low: float
    high: float
    attempted: int
    done: int


def success(asks: Iterable[Ask], low: float, high: float) -> list[Bin]:
    """Return the success of attempted jobs against the channel's value, which is taken to lie between low and high.

    There are at most twelve bins of equal, round width; empty ones between others are among them.
    """
    pairs = [
        (min(max(ask.value, low), high), ask.outcome == REACHED)
        for ask in asks if ask.value is not None and ask.outcome in ATTEMPTED
    ]  # fmt: skip
    if not pairs:
        return []
    least, most = min(value for value, _ in pairs), max(value for value, _ in pairs)
    step = round_step(least, most)
    first = floor(least / step)
    total, done = Counter[int](), Counter[int]()
    for value, reached in pairs:
        total[floor(value / step)] += 1
        done[floor(value / step)] += reached
    return [Bin(n * step, (n + 1) * step, total[n], done[n]) for n in range(first, max(total) + 1)]


def round_step(least: float, most: float) -> float:
    """Return the least of 1, 2, 5, 10, 20... that divides a range into at most twelve parts."""
    step = 10.0 ** max(0, floor(log10(max((most - least) / MOST_BINS, 1.0))))
    while True:
        for factor in (1.0, 2.0, 5.0):
            if floor(most / (step * factor)) - floor(least / (step * factor)) < MOST_BINS:
                return step * factor
        step *= 10.0


def course(motions: Iterable[Motion], channel: str, start: datetime, end: datetime) -> list[tuple[float, float]]:
    """Return the course of a channel: hours from `start`, and the mean of the readings in each five minutes."""
    width = (end - start) / MOST_POINTS
    sums: dict[int, tuple[float, int]] = {}
    for motion in motions:
        for at, told in ((motion.began_at, motion.first), (motion.ended_at, motion.last)):
            if channel in told and start <= at < end:
                place = int((at - start) / width)
                total, count = sums.get(place, (0.0, 0))
                sums[place] = total + told[channel], count + 1
    each_h = width / timedelta(hours=1)
    return [((place + 0.5) * each_h, total / count) for place, (total, count) in sorted(sums.items())]
