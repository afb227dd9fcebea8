"""What is counted a day, and the days on which a sum passed a round number. Pure: no database, no clock."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import date

STEPS = tuple(factor * 10**power for power in range(2, 13) for factor in (1, 5))


@dataclass(frozen=True)
class Figure:
    """A figure of a day: its name in rows, its title, what it means, and what one is called in a milestone.

    `size`: it is shown in units of so many. `adds_up`: the sum over days means something.
    """

    name: str
    title: str
    means: str
    first: str = ""
    nth: str = ""
    size: float = 1.0
    adds_up: bool = True

    def in_unit(self, value: float) -> float:
        """Return a value in the unit in which it is shown."""
        return value / self.size


FIGURES = (
    Figure("hits", "Page views", "Pages that people's browsers were shown; programs that say what they are, such as "
           "search engines, and checks of the server are left out.", "First page view", "{} page views"),
    Figure("addresses", "Unique addresses", "Different network addresses from which these pages were asked for, about "
           "1 % off. No address is stored; somebody who comes on two days counts on both.",
           "First visitor", "{} visitors, each counted once a day"),
    Figure("turns", "Turns", "Turns that began.", "First turn", "{} turns"),
    Figure("commands", "Commands", "Commands of turns and jobs that a robot took.", "First command", "{} commands"),
    Figure("entries", "Log entries", "Entries that operators wrote in the log.", "First log entry", "{} log entries"),
    Figure("finds", "Finds", "Finds that operators reported on that day and a moderator confirmed.", "First find",
           "{} finds"),
    Figure("watching", "Most watching at once", "The most people who watched at the same time.", adds_up=False),
    Figure("online_s", "Hours online", "Hours in which a robot was reachable; of the portal, all robots together.",
           "", "{} hours online", 3600.0),
    Figure("sent_bytes", "Sent live (GB)", "Pictures, states and sound sent to people who watched, in GB.",
           "", "{} GB sent", 1e9),
)  # fmt: skip
BY_NAME = {figure.name: figure for figure in FIGURES}


@dataclass(frozen=True)
class Day:
    """The figures of a day by name; None: not known. `whole`: no address was left out."""

    day: date
    values: dict[str, float | None]
    whole: bool = True


@dataclass(frozen=True)
class Milestone:
    """A day on which the sum of a figure reached a round number."""

    day: date
    figure: str
    number: float
    text: str


@dataclass(frozen=True)
class Total:
    """The sum of a figure over all days; `whole`: each day's number is known."""

    figure: Figure
    value: float
    whole: bool


def milestones(days: Iterable[Day]) -> list[Milestone]:
    """Return the milestones in the order of time: the first of each figure, and of a day the greatest that it passed.

    A day whose number is not known adds nothing, so a milestone may be late, and never early.
    """
    sums = dict.fromkeys((figure.name for figure in FIGURES if figure.adds_up), 0.0)
    found = []
    for one in days:
        for name in sums:
            figure, before = BY_NAME[name], sums[name]
            sums[name] = after = before + figure.in_unit(max(0.0, one.values.get(name) or 0.0))
            if before == 0.0 < after and figure.first:
                found.append(Milestone(one.day, name, 1, figure.first))
            passed = [step for step in STEPS if before < step <= after]
            if passed:
                found.append(Milestone(one.day, name, passed[-1], figure.nth.format(f"{passed[-1]:,}")))
    return found


def totals(days: Sequence[Day]) -> list[Total]:
    """Return the sum of each figure that adds up, in the unit in which it is shown."""
    found = []
    for figure in FIGURES:
        if figure.adds_up:
            values = [one.values.get(figure.name) for one in days]
            known = [figure.in_unit(value) for value in values if value is not None]
            whole = len(known) == len(days) and (figure.name != "addresses" or all(one.whole for one in days))
            found.append(Total(figure, sum(known), whole))
    return found
