"""The report on 24 hours, for page and JSON: rows, goals an hour, success, the course of a channel."""

from dataclasses import asdict, dataclass, field
from datetime import datetime
from typing import Any

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
        return "not known" if self.value is None else f"{self.value:,.{self.digits}f} {self.unit}".strip()


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
    counts, many = outcomes(found.asks), f"{declared.job}s".capitalize()
    tried = attempted(counts)
    share = 100.0 * counts[REACHED] / tried if tried else None
    return [
        Row(f"{many} asked for", len(found.asks)),
        Row("People and guests who asked", len({ask.asker for ask in found.asks})),
        Row(f"{many} attempted", tried),
        Row(f"{many} {declared.done}", counts[REACHED]),
        Row(f"{declared.done.capitalize()}, of those attempted", share, "%", 1),
        Row("Given up by the robot", counts[GAVE_UP]),
        Row("Ended by faults of the robot", counts[FAULT]),
        Row("Cut off; how they ended is not known", counts[UNKNOWN]),
        *(Row(label, counts[code]) for code, label in declared.ends),
        Row("Refused by the robot", counts[REFUSED]),
        Row("Cancelled or stopped by people", counts[CANCELLED]),
        Row("Still waiting or under way", counts[OPEN]),
    ]


def _use(use: Use, span: Span) -> list[Row]:
    """Return the rows that the portal counts of every robot."""
    share = None if use.online_s is None or not span.seconds else 100.0 * min(1.0, use.online_s / span.seconds)
    sent = None if use.sent_bytes is None else use.sent_bytes / 1e6
    rate = None if sent is None or not span.seconds else 8000 * sent / span.seconds
    return [
        Row("Time online", share, "%", 1),
        Row("Most visitors at once", use.watching),
        Row("Sent to visitors, live", sent, "MB", 1),
        Row("Sent to visitors, live, on average", rate, "kbit/s", 1),
    ]


def _own(row: Total | Times | Share, found: DayRecord, spec: Spec, span: Span) -> Row:
    """Return a row that the robot adds."""
    if isinstance(row, Times):
        ends = (CommandState.FAILED, CommandState.REJECTED) if row.failed else (CommandState.COMPLETED,)
        within = (m for m in found.motions if m.kind == row.kind and m.state in ends and m.ended_at < span.end)
        return Row(row.label, sum(1 for _ in within))
    if isinstance(row, Share):
        busy = seconds_of(found.motions, row.kinds, span.start, span.until)
        return Row(row.label, 100.0 * busy / span.seconds if span.seconds else None, "%", 1)
    earlier = readings(reversed(found.before), row.channel)
    grown = growth(readings(found.motions, row.channel), earlier[-1] if earlier else None)
    unit = next((c.unit for c in spec.channels if c.name == row.channel), "")
    return Row(row.label, grown, unit, 1 if unit else 0)
