"""The admin of records that are read, never written by hand."""

from typing import Any

from django.contrib import admin
from django.http import HttpRequest


class Kept(admin.ModelAdmin):  # type: ignore[type-arg]
    """A record that is read, never written by hand."""

    def has_keep_permission(self, request: HttpRequest) -> bool:
        """Actions that touch a robot or a turn are for keepers, not for everybody who may look."""
        return request.user.has_perm("robots.change_robot")

    def has_add_permission(self, request: HttpRequest) -> bool:
        """Nobody adds history."""
        return False

    def has_change_permission(self, request: HttpRequest, obj: Any = None) -> bool:
        """Nobody changes history."""
        return False

    def has_delete_permission(self, request: HttpRequest, obj: Any = None) -> bool:
        """Nobody deletes history."""
        return False
