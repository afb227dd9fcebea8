"""Base classes of admin pages: actions with permissions that say what they did, and read-only records."""

from collections.abc import Callable, Iterable
from typing import Any

from django.contrib import admin, messages
from django.contrib.admin.utils import model_ngettext
from django.core.exceptions import PermissionDenied
from django.http import HttpRequest, HttpResponse

from robots.kit.contract.errors import RobotError


class Guarded(admin.ModelAdmin):  # type: ignore[type-arg]
    """A list whose actions answer 403 to people without the permission; Django would ignore them silently."""

    def changelist_view(self, request: HttpRequest, extra_context: dict[str, Any] | None = None) -> HttpResponse:
        """Show the list, or carry out an action on it."""
        wanted = request.POST.get("action", "")
        known = {getattr(action, "__name__", action) for action in self.actions or ()} | {"delete_selected"}
        if wanted in known and wanted not in self.get_actions(request):
            raise PermissionDenied
        return super().changelist_view(request, extra_context)

    def act_on(
        self, request: HttpRequest, chosen: Iterable[Any], verb: Callable[[Any], bool], word: str, rest: str
    ) -> None:
        """Carry out a verb on each chosen row, note it in the row's history, and say on how many.

        `verb` returns whether it did anything; `rest` says why it had nothing to do. A refusal is told by row.
        """
        done = others = 0
        for one in chosen:
            try:
                changed = verb(one)
            except RobotError as error:
                messages.warning(request, f"{one}: {error}")
                continue
            if changed:
                self.log_change(request, one, word)
            done, others = done + changed, others + (not changed)
        counts = [(count, text) for count, text in ((done, word), (others, rest)) if count]
        told = [f"{text}: {count} {model_ngettext(self.opts, count)}." for count, text in counts]
        if told:
            messages.add_message(request, messages.SUCCESS if done else messages.INFO, " ".join(told))


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
