"""The menu of the admin: groups by purpose, robots first, and the pages outside of the admin that belong to each."""

from typing import Any

from django.urls import reverse
from django.utils.translation import gettext_lazy

GROUPS = (
    ("robots", "alerts"),
    ("queueing",),
    ("operatorlog",),
    ("accounts", "account", "auth"),
)  # named as the first app
FIRST = ("Robot", "Queue", "Entry", "User")  # models that lead their group
# app: name of a page, name of its address, the permission that it wants
PAGES = {
    "robots": (
        (gettext_lazy("Status page"), "status", ""),
        (gettext_lazy("Statistics"), "daily", ""),
        (gettext_lazy("Movie of the day"), "movie-of-the-day", ""),
    ),
    "operatorlog": (
        (gettext_lazy("Review entries"), "admin:operatorlog_entry_review", "operatorlog.change_entry"),
        (gettext_lazy("Log as visitors see it"), "log", ""),
        (gettext_lazy("Survey results"), "survey-results", "operatorlog.view_surveyresponse"),
    ),
}


def in_groups(apps: list[dict[str, Any]], user: Any) -> list[dict[str, Any]]:
    """Return Django's list of apps as the groups of the menu; an app of no group comes last."""
    by_label = {app["app_label"]: app for app in apps}
    grouped = []
    for labels in GROUPS:
        found = [by_label.pop(label) for label in labels if label in by_label]
        if not found:
            continue
        models = sorted(
            (m for app in found for m in app["models"]), key=lambda m: (m["object_name"] not in FIRST, m["name"])
        )
        grouped.append({**found[0], "models": [*models, *_pages(labels[0], user)]})
    return [*grouped, *by_label.values()]


def _pages(group: str, user: Any) -> list[dict[str, Any]]:
    return [
        {"name": str(name), "object_name": address, "admin_url": reverse(address), "add_url": None, "view_only": True,
         "perms": {"view": True}}
        for name, address, permission in PAGES.get(group, ())
        if not permission or user.has_perm(permission)
    ]  # fmt: skip
