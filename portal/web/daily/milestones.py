"""What is counted a day, and the days on which a sum passed a round number. Pure: no database, no clock."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import date
from typing import TYPE_CHECKING

from django.utils.formats import number_format
from django.utils.translation import gettext_lazy

if TYPE_CHECKING:
    from django.utils.functional import _StrPromise

    Text = str | _StrPromise

STEPS = tuple(factor * 10**power for power in range(2, 13) for factor in (1, 5))


@dataclass(frozen=True)
class Figure:
    """A figure of a day: its name in rows, its title, what it means, and what one is called in a milestone.

    `size`: it is shown in units of so many. `adds_up`: the sum over days means something. Without words for one and
    many it has no milestones.
    """

    name: str
    title: "Text"
    means: "Text"
    first: "Text" = ""
    nth: "Text" = ""
    size: float = 1.0
    adds_up: bool = True

    def in_unit(self, value: float) -> float:
        """Return a value in the unit in which it is shown."""
        return round(value / self.size, 9)  # so that 0.29 in % is 29


FIGURES = (
    Figure(
        "hits",
        gettext_lazy("Page views"),
        gettext_lazy(
            "Pages that people's browsers were shown; programs that say what they are, such as search engines, "
            "and checks of the server are left out."
        ),
        gettext_lazy("First page view"),
        gettext_lazy("{} page views"),
    ),
    Figure(
        "addresses",
        gettext_lazy("Unique addresses"),
        gettext_lazy(
            "Different network addresses from which these pages were asked for, about 1 % off. No address is "
            "stored; somebody who comes on two days counts on both."
        ),
        gettext_lazy("First visitor"),
        gettext_lazy("{} visitors, each counted once a day"),
    ),
    Figure(
        "turns",
        gettext_lazy("Turns"),
        gettext_lazy("Turns that began."),
        gettext_lazy("First turn"),
        gettext_lazy("{} turns"),
    ),
    Figure(
        "commands",
        gettext_lazy("Commands"),
        gettext_lazy("Commands of turns and jobs that a robot took."),
        gettext_lazy("First command"),
        gettext_lazy("{} commands"),
    ),
    Figure(
        "entries",
        gettext_lazy("Log entries"),
        gettext_lazy("Entries that operators wrote in the log."),
        gettext_lazy("First log entry"),
        gettext_lazy("{} log entries"),
    ),
    Figure(
        "finds",
        gettext_lazy("Finds"),
        gettext_lazy("Finds that operators reported on that day and a moderator confirmed."),
        gettext_lazy("First find"),
        gettext_lazy("{} finds"),
    ),
    Figure(
        "watching",
        gettext_lazy("Most watching at once"),
        gettext_lazy("The most people who watched at the same time."),
        adds_up=False,
    ),
    Figure(
        "online_s",
        gettext_lazy("Hours online"),
        gettext_lazy("Hours in which a robot was reachable; of the portal, all robots together."),
        "",
        gettext_lazy("{} hours online"),
        3600.0,
    ),
    Figure(
        "sent_bytes",
        gettext_lazy("Sent live (GB)"),
        gettext_lazy("Pictures, states and sound sent to people who watched, in GB."),
        "",
        gettext_lazy("{} GB sent"),
        1e9,
    ),
    Figure(
        "wait_median_s",
        gettext_lazy("Wait, median (min)"),
        gettext_lazy(
            "Half of the people whose turn began on that day had waited less, from joining the queue to control. A day "
            "on which no turn began has no wait."
        ),
        size=60.0,
        adds_up=False,
    ),
    Figure(
        "wait_longest_s",
        gettext_lazy("Wait, longest (min)"),
        gettext_lazy("The longest wait of somebody whose turn began on that day."),
        size=60.0,
        adds_up=False,
    ),
    Figure(
        "success",
        gettext_lazy("Commands carried out (%)"),
        gettext_lazy(
            "Of the commands of turns and jobs that a robot took, without those that somebody cancelled or stopped. A "
            "day without any has no share."
        ),
        size=0.01,
        adds_up=False,
    ),
    Figure(
        "faults",
        gettext_lazy("Faults"),
        gettext_lazy("Faults of robots that the portal noted, also those that were over by themselves."),
    ),
    Figure(
        "outages",
        gettext_lazy("Outages"),
        gettext_lazy("Times in which a robot was switched on and its worker did not answer for two minutes or longer."),
    ),
)
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
                found.append(Milestone(one.day, name, 1, str(figure.first)))
            passed = [step for step in STEPS if before < step <= after]
            if passed and figure.nth:
                number = number_format(passed[-1], force_grouping=True)
                found.append(Milestone(one.day, name, passed[-1], figure.nth.format(number)))
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
