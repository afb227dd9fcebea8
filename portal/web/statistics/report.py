"""The report on 24 hours, for page and JSON: rows, goals an hour, success, the course of a channel."""

from dataclasses import asdict, dataclass, field
from datetime import datetime
from typing import Any

from django.utils.formats import number_format
from django.utils.text import capfirst
from django.utils.translation import gettext

from portal.web.statistics.counting import (
    CANCELLED,
    FAULT,
    GAVE_UP,
    OPEN,
    REACHED,
    REFUSED,
    UNKNOWN,
    Bin,
    attempted,
    by_hour,
    course,
    growth,
    outcomes,
    readings,
    seconds_of,
    success,
)
from portal.web.statistics.day import Span
from portal.web.statistics.reading import DayRecord, Use
from robots.kit.contract.capabilities import Share, Statistics, Times, Total
from robots.kit.contract.spec import Spec
from robots.sentences import translate
from robots.states import CommandState


@dataclass(frozen=True)
class Row:
    """One row of the table; `value` is None where nothing is known."""

    label: str
    value: float | None
    unit: str = ""
    digits: int = 0

    @property
    def text(self) -> str:
        """Return the value as people read it."""
        if self.value is None:
            return gettext("not known")
        return f"{number_format(f'{self.value:.{self.digits}f}', self.digits, force_grouping=True)} {self.unit}".strip()


@dataclass(frozen=True)
class JobWords:
    """What the robot calls one job, several of them, and one that is done, in the reader's language."""

    job: str
    jobs: str
    done: str


def words_of(declared: Statistics) -> JobWords:
    """Return the words for a robot's jobs."""
    return JobWords(translate(declared.job), translate(f"{declared.job}s"), translate(declared.done))


@dataclass(frozen=True)
class Report:
    """Everything about 24 hours of one robot."""

    rows: list[Row]
    hours: list[tuple[int, int]]
    success: list[Bin]
    course: list[tuple[float, float]]
    cut: bool = False
    declared: Statistics = field(default_factory=Statistics)

    def as_json(self, span: Span) -> dict[str, Any]:
        """Return it as JSON for other software; times in UTC."""
        return {
            "from": _stamp(span.start), "to": _stamp(span.end), "until": _stamp(span.until),
            "complete": not self.cut,
            "rows": [{"label": r.label, "value": r.value, "unit": r.unit} for r in self.rows],
            "hours": [{"hour": n, "asked": asked, "done": done} for n, (asked, done) in enumerate(self.hours)],
            "success": {"against": self.declared.against, "bins": [asdict(one) for one in self.success]},
            "over_time": {
                "channel": self.declared.over_time,
                "points": [{"hour": round(h, 3), "value": round(v, 4)} for h, v in self.course],
            },
        }  # fmt: skip


def _stamp(at: datetime) -> str:
    """Return a time as it may stand in an address, too."""
    return at.strftime("%Y-%m-%dT%H:%M:%SZ")


def report_of(history: DayRecord, spec: Spec, declared: Statistics, span: Span) -> Report:
    """Return the report on these jobs and motions."""
    low, high = next(((c.low, c.high) for c in spec.channels if c.name == declared.against), (0.0, 0.0))
    return Report(
        [
            *_jobs(history, declared),
            *(_own(row, history, spec, span) for row in declared.rows),
            *_use(history.use, span),
        ],
        by_hour(history.asks, span.start),
        success(history.asks, low, high),
        course(history.motions, declared.over_time, span.start, span.end) if declared.over_time else [],
        history.cut,
        declared,
    )


def _jobs(found: DayRecord, declared: Statistics) -> list[Row]:
    counts, words = outcomes(found.asks), words_of(declared)
    many, done = capfirst(words.jobs), words.done
    tried = attempted(counts)
    share = 100.0 * counts[REACHED] / tried if tried else None
    return [
        Row(gettext("{jobs} asked for").format(jobs=many), len(found.asks)),
        Row(gettext("People and guests who asked"), len({ask.asker for ask in found.asks})),
        Row(gettext("{jobs} attempted").format(jobs=many), tried),
        Row(gettext("{jobs} {done}").format(jobs=many, done=done), counts[REACHED]),
        Row(gettext("{done}, of those attempted").format(done=capfirst(done)), share, "%", 1),
        Row(gettext("Given up by the robot"), counts[GAVE_UP]),
        Row(gettext("Ended by faults of the robot"), counts[FAULT]),
        Row(gettext("Cut off; how they ended is not known"), counts[UNKNOWN]),
        *(Row(translate(label), counts[code]) for code, label in declared.ends),
        Row(gettext("Refused by the robot"), counts[REFUSED]),
        Row(gettext("Cancelled or stopped by people"), counts[CANCELLED]),
        Row(gettext("Still waiting or under way"), counts[OPEN]),
    ]


def _use(use: Use, span: Span) -> list[Row]:
    """Return the rows that the portal counts of every robot."""
    share = None if use.online_s is None or not span.seconds else 100.0 * min(1.0, use.online_s / span.seconds)
    sent = None if use.sent_bytes is None else use.sent_bytes / 1e6
    rate = None if sent is None or not span.seconds else 8000 * sent / span.seconds
    return [
        Row(gettext("Time online"), share, "%", 1),
        Row(gettext("Most visitors at once"), use.watching),
        Row(gettext("Sent to visitors, live"), sent, "MB", 1),
        Row(gettext("Sent to visitors, live, on average"), rate, "kbit/s", 1),
    ]


def _own(row: Total | Times | Share, found: DayRecord, spec: Spec, span: Span) -> Row:
    """Return a row that the robot adds."""
    label = translate(row.label)
    if isinstance(row, Times):
        ends = (CommandState.FAILED, CommandState.REJECTED) if row.failed else (CommandState.COMPLETED,)
        within = (m for m in found.motions if m.kind == row.kind and m.state in ends and m.ended_at < span.end)
        return Row(label, sum(1 for _ in within))
    if isinstance(row, Share):
        busy = seconds_of(found.motions, row.kinds, span.start, span.until)
        return Row(label, 100.0 * busy / span.seconds if span.seconds else None, "%", 1)
    earlier = readings(reversed(found.before), row.channel)
    grown = growth(readings(found.motions, row.channel), earlier[-1] if earlier else None)
    unit = next((c.unit for c in spec.channels if c.name == row.channel), "")
    return Row(label, grown, unit, 1 if unit else 0)
