"""Links on a robot's page of the admin to the pages and lists about it."""

from collections.abc import Callable
from typing import Any

from django.urls import reverse
from django.utils.translation import gettext_lazy

from robots.models import Robot

Link = tuple[Any, str, Callable[[Robot], str]]  # its words, the permission that it wants, its address


def rows_of(words: Any, model: str) -> Link:
    """Return the link to the rows of a robot in the list of a model, for people who may see them."""
    app, name = model.split(".")
    return (
        words,
        f"{app}.view_{name}",
        lambda robot: f"{reverse(f'admin:{app}_{name}_changelist')}?robot__id__exact={robot.pk}",
    )


MORE: list[Link] = [
    (gettext_lazy("Recordings"), "", lambda robot: f"{robot.get_absolute_url()}recordings/"),
    (gettext_lazy("Jobs, as visitors see them"), "", lambda robot: f"{robot.get_absolute_url()}jobs/"),
    (gettext_lazy("Statistics"), "", lambda robot: f"/statistics/?robot={robot.slug}"),
    rows_of(gettext_lazy("Turns"), "queueing.turn"),
    rows_of(gettext_lazy("Jobs"), "queueing.job"),
    rows_of(gettext_lazy("Log entries"), "operatorlog.entry"),
    rows_of(gettext_lazy("Programs"), "robots.program"),
    rows_of(gettext_lazy("Pictures"), "robots.frame"),
    rows_of(gettext_lazy("Clearances"), "accounts.clearance"),
]


def links_about(robot: Robot, user: Any) -> list[tuple[str, str]]:
    """Return words and address of each link that this person may follow."""
    return [(str(words), address(robot)) for words, may, address in MORE if not may or user.has_perm(may)]
