"""The site of the admin: one door for all, robots first in the menu, and the live first page."""

from typing import Any

from allauth.account.decorators import secure_admin_login
from django.contrib import admin
from django.http import HttpRequest, HttpResponse
from django.urls import URLPattern, URLResolver, path
from django.utils.translation import gettext, gettext_lazy

from portal.web.staff.menu import in_groups
from robots.once import once


class StaffSite(admin.AdminSite):
    """The admin. A form for a new row makes one row, also if it is sent twice."""

    site_header = site_title = "Farhand"
    index_title = gettext_lazy("All robots")
    index_template = "admin/index.html"

    def register(self, model_or_iterable: Any, admin_class: Any = None, **options: Any) -> None:
        """Register pages for these models."""
        before = set(self._registry)
        super().register(model_or_iterable, admin_class, **options)
        for model in self._registry.keys() - before:
            page = self._registry[model]
            page.add_view = once(page.add_view)  # type: ignore[method-assign]

    def login(self, request: HttpRequest, extra_context: Any = None) -> HttpResponse:
        """Lead to the sign-in of all people."""
        answer: HttpResponse = secure_admin_login(super().login)(request, extra_context)
        return answer

    def get_urls(self) -> list[URLPattern | URLResolver]:
        """Add the live part of the first page."""
        return [path("live/", self.admin_view(self.live), name="live"), *super().get_urls()]

    def index(self, request: HttpRequest, extra_context: dict[str, Any] | None = None) -> Any:
        """Show all robots, what waits for staff, and the menu."""
        shown = self._first_page(request)
        title = self.index_title if shown["sees_robots"] else gettext("Overview")
        return super().index(request, {**shown, "title": title, **(extra_context or {})})

    def live(self, request: HttpRequest) -> HttpResponse:
        """Return the live part of the first page alone."""
        from django.shortcuts import render  # noqa: PLC0415

        return render(request, "admin/live.html", self._first_page(request))

    @staticmethod
    def _first_page(request: HttpRequest) -> dict[str, Any]:
        from portal.web.staff.first_page import first_page  # noqa: PLC0415 - of web processes alone

        return first_page(request.user)

    def get_app_list(self, request: HttpRequest, app_label: str | None = None) -> list[Any]:
        """Return the menu in groups by purpose; of one app, if it is named."""
        apps = super().get_app_list(request, app_label)
        return apps if app_label else in_groups(apps, request.user)
