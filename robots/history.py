"""Base classes of admin pages: actions with permissions, and read-only records."""

from typing import Any

from django.contrib import admin
from django.core.exceptions import PermissionDenied
from django.http import HttpRequest, HttpResponse


class Guarded(admin.ModelAdmin):  # type: ignore[type-arg]
    """A list whose actions answer 403 to people without the permission; Django would ignore them silently."""

    def changelist_view(self, request: HttpRequest, extra_context: dict[str, Any] | None = None) -> HttpResponse:
        """Show the list, or carry out an action on it."""
        wanted = request.POST.get("action", "")
        known = {getattr(action, "__name__", action) for action in self.actions or ()} | {"delete_selected"}
        if wanted in known and wanted not in self.get_actions(request):
            raise PermissionDenied
        return super().changelist_view(request, extra_context)


class Kept(Guarded):
    """A record that is only read in the admin."""

    def has_act_permission(self, request: HttpRequest) -> bool:
        """Return whether the person may act on robots and turns; to look at them a lower permission is enough."""
        return request.user.has_perm("robots.change_robot")

    def has_add_permission(self, request: HttpRequest) -> bool:
        """Return False: history is not added by hand."""
        return False

    def has_change_permission(self, request: HttpRequest, obj: Any = None) -> bool:
        """Return False: history does not change."""
        return False

    def has_delete_permission(self, request: HttpRequest, obj: Any = None) -> bool:
        """Return False: history is not deleted."""
        return False
