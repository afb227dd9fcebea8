"""Links on a robot's page of the admin to the pages and lists about it."""

from collections.abc import Callable, Iterator
from typing import Any

from django.contrib import admin
from django.http import HttpRequest
from django.urls import reverse
from django.utils.text import capfirst
from django.utils.translation import gettext

from robots.models import Robot

Link = tuple[str, str]  # its words, and its address
MORE: list[Callable[[Robot, HttpRequest], Link | None]] = []


def about(link: Callable[[Robot, HttpRequest], Link | None]) -> Callable[[Robot, HttpRequest], Link | None]:
    """Have robots' pages show a link of another app too, where it is not None."""
    MORE.append(link)
    return link


def links_about(robot: Robot, request: HttpRequest) -> list[Link]:
    """Return words and address of each link that this person may follow: public pages, then lists of the admin."""
    page = robot.get_absolute_url()
    return [
        (gettext("Recordings, as visitors see them"), f"{page}recordings/"),
        (gettext("Jobs, as visitors see them"), f"{page}jobs/"),
        (gettext("Statistics"), f"/statistics/?robot={robot.slug}"),
        *(found for link in MORE if (found := link(robot, request)) is not None),
        *sorted(_lists(robot, request)),
    ]


def _lists(robot: Robot, request: HttpRequest) -> Iterator[Link]:
    """Yield each list that has a filter by robot, filtered to this one."""
    for model, page in admin.site._registry.items():
        filters: Any = page.list_filter
        of_robot = next((one for one in filters if isinstance(one, str) and one.rsplit("__")[-1] == "robot"), None)
        if of_robot is not None and page.has_view_permission(request):
            address = reverse(f"admin:{model._meta.app_label}_{model._meta.model_name}_changelist")
            yield str(capfirst(model._meta.verbose_name_plural)), f"{address}?{of_robot}__id__exact={robot.pk}"
