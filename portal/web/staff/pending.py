"""What waits for staff, as one list: robots, incidents, programs for the gallery, entries of the log, finds."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

from django.db.models import QuerySet
from django.urls import reverse
from django.utils.translation import gettext, gettext_lazy

from operatorlog.models import Entry, Find, Visibility
from operatorlog.services import finds_to_decide, to_review
from queueing.services import waits_for_staff
from robots.kit.clock import SYSTEM
from robots.models import Frame, Incident, Program, Robot
from robots.people import shown_name
from robots.sentences import translate
from robots.services import StopShown, stop_shown
from robots.services.programs import to_approve

MOST = 20  # of each kind, the newest


@dataclass(frozen=True)
class Halt:
    """What holds a robot until staff act: its latched stop, or its jobs and own behaviour that wait to be resumed."""

    robot: Robot
    stop: StopShown | None
    suspended: bool


@dataclass(frozen=True)
class Act:
    """A button that resolves an item: its label, and the form that it sends."""

    label: str
    address: str
    fields: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Item:
    """One thing that waits: what it is, since when, and the page and buttons that resolve it."""

    key: str  # of its row on the page
    kind: str
    what: str
    since: datetime
    url: str
    link: str
    acts: tuple[Act, ...] = ()
    text: str = ""  # of people, to be read before the decision
    folded: bool = False  # the text is long
    frame: Frame | None = None
    shows: str = ""  # what the picture is, in words


@dataclass(frozen=True)
class Kind:
    """How many things of a kind wait, how many of them are listed, and the page that lists all."""

    name: str
    count: int
    listed: int
    url: str


@dataclass(frozen=True)
class Pending:
    """The kinds that the person may decide on, and the items of all, the oldest first."""

    kinds: tuple[Kind, ...]
    items: tuple[Item, ...]


def halts(robots: Iterable[Robot], now: datetime) -> list[Halt]:
    """Return what holds each of these robots."""
    return [Halt(robot, stop_shown(robot, now), waits_for_staff(robot)) for robot in robots]


def sees_robots(user: Any) -> bool:
    """Tell whether this member of staff may see robots in the admin."""
    return bool(user.has_perm("robots.view_robot") or user.has_perm("robots.change_robot"))


def pending(user: Any, now: datetime | None = None, known: Sequence[Halt] | None = None) -> Pending:
    """Return what waits and this person may see. `known`: what holds the robots, where that was read already."""
    now = now or SYSTEM.now()
    kinds: list[Kind] = []
    items: list[Item] = []
    if sees_robots(user):
        on = halts(Robot.objects.filter(enabled=True), now) if known is None else [h for h in known if h.robot.enabled]
        found = [item for halt in on for item in _of_robot(halt, user, now)]
        kinds.append(Kind(gettext("Robots"), len(found), len(found), list_of(Robot)))
        items += found
    for name, permission, rows, order, item, page in _LISTS:
        if user.has_perm(permission):
            waiting = rows()
            listed = [item(row, user) for row in waiting.order_by(f"-{order}")[:MOST]]
            all_of_them = list_of(waiting.model) + page if page.startswith("?") else reverse(page)
            kinds.append(
                Kind(str(name), waiting.count() if len(listed) == MOST else len(listed), len(listed), all_of_them)
            )
            items += listed
    return Pending(tuple(kinds), tuple(sorted(items, key=lambda one: one.since)))


def list_of(model: Any) -> str:
    """Return the address of the admin's list of a model, or of a row's model."""
    return reverse(f"admin:{model._meta.app_label}_{model._meta.model_name}_changelist")


def _action(row: Any, label: str, name: str) -> Act:
    """Return the button that runs an action of the row's list."""
    return Act(label, list_of(row), {"action": name, "_selected_action": str(row.pk)})


def _page(row: Any) -> str:
    model = row._meta
    return reverse(f"admin:{model.app_label}_{model.model_name}_change", args=[row.pk])


def _of_robot(halt: Halt, user: Any, now: datetime) -> list[Item]:
    """Return what staff have to do at a robot: look and release its stop, or resume its jobs."""
    robot, since, to_card = halt.robot, halt.robot.stopped_at, gettext("Go to its card")
    if halt.stop is not None:
        words = gettext("{robot} is stopped: look at its newest picture, then release the stop.").format(robot=robot)
        return [Item(f"stop-{robot.pk}", gettext("Robot"), words, since or now, f"#robot-{robot.slug}", to_card)]
    if since is None or not halt.suspended:
        return []
    words = gettext("{robot} was stopped: its jobs and its own behaviour wait until they are resumed.")
    address = reverse("admin:robots_robot_do", args=[robot.pk, "resume_jobs"])
    acts = (Act(gettext("Resume jobs"), address),) if user.has_perm("robots.change_robot") else ()
    said = words.format(robot=robot)
    return [Item(f"stop-{robot.pk}", gettext("Robot"), said, since, f"#robot-{robot.slug}", to_card, acts)]


def _of_incident(row: Incident, user: Any) -> Item:
    acts = (_action(row, gettext("Dealt with"), "close"),) if user.has_perm("robots.change_robot") else ()
    text = f"{row.robot}: {translate(row.text)} {translate(row.remedy)}".strip()
    return Item(f"incident-{row.pk}", gettext("Incident"), text, row.at, _page(row), gettext("Look at it"), acts)


def _of_program(row: Program, user: Any) -> Item:
    acts = (_action(row, gettext("Take into the gallery"), "take_in"), _action(row, gettext("Decline"), "take_out"))
    words = gettext("{author} shares the program {name!r} for {robot}.")
    return Item(
        f"program-{row.pk}", gettext("Program"), words.format(author=row.author, name=row.name, robot=row.robot),
        row.changed_at, _page(row), gettext("Open it"), acts, row.text, folded=True,
    )  # fmt: skip


def _of_entry(row: Entry, user: Any) -> Item:
    shown = row.visibility != Visibility.HIDDEN
    acts = (
        (_action(row, gettext("Keep it published"), "publish"), _action(row, gettext("Feature"), "feature"))
        if shown
        else ()
    )
    appeal = row.appeals.filter(answer=None).last()
    if appeal is not None:
        words = gettext("{author} asks for another look at a hidden entry about {robot}.")
    elif row.edited_at:
        words = gettext("{author} changed an entry about {robot}.")
    else:
        words = gettext("{author} wrote about {robot}.")
    return Item(
        f"entry-{row.pk}", gettext("Entry"), words.format(author=shown_name(row.author_name), robot=row.robot),
        appeal.at if appeal else row.edited_at or row.written_at, _page(row),
        gettext("Hide it, with a reason") if shown else gettext("Decide on the hidden entry"),
        acts, row.text, frame=row.frame, shows=gettext("Picture of this entry"),
    )  # fmt: skip


def _of_find(row: Find, user: Any) -> Item:
    words = gettext("{author} reports a find with {robot}.")
    return Item(
        f"find-{row.pk}", gettext("Find"), words.format(author=shown_name(row.author_name), robot=row.round.robot),
        row.reported_at, _page(row), gettext("Choose which piece it is"),
        (_action(row, gettext("Decline"), "decline"),), row.name, frame=row.frame,
        shows=gettext("Picture of this find"),
    )  # fmt: skip


# name, permission, rows that wait, order, item, the page of all: a filter of the list, or a page's name
_LISTS: tuple[tuple[Any, str, Callable[[], QuerySet[Any]], str, Callable[[Any, Any], Item], str], ...] = (
    (
        gettext_lazy("Incidents"), "robots.view_incident",
        lambda: Incident.objects.filter(closed_at=None).select_related("robot"), "at", _of_incident,
        "?closed_at__isnull=1",
    ),
    (
        gettext_lazy("Programs"), "robots.change_program",
        lambda: to_approve().select_related("robot", "author"), "changed_at", _of_program, "?waits=decision",
    ),
    (
        gettext_lazy("Entries"), "operatorlog.change_entry",
        lambda: to_review().select_related("robot", "author", "frame"), "written_at", _of_entry,
        "admin:operatorlog_entry_review",
    ),
    (
        gettext_lazy("Finds"), "operatorlog.change_find",
        lambda: finds_to_decide().select_related("round__robot", "author", "frame"), "reported_at", _of_find,
        "?state__exact=reported",
    ),
)  # fmt: skip
