"""Admin pages of what robots did: commands, grants, incidents, pictures; and of people's programs."""

from typing import Any

from django.contrib import admin, messages
from django.http import HttpRequest
from django.utils.safestring import SafeString

from robots import services
from robots.admin.bases import FormFieldsAdmin, GuardedAdmin, NamedValues, ReadOnlyAdmin, thumbnail
from robots.models import Command, Frame, Grant, Incident, Program
from robots.services import programs


@admin.register(Program)
class ProgramAdmin(FormFieldsAdmin, GuardedAdmin):
    """People's programs, reviewed for the gallery."""

    list_display = ("name", "robot", "author", "shared", "approved", "changed_at")
    list_filter = ("robot", "shared", "approved")
    search_fields = ("name", "text")
    fields = ("robot", "author", "name", "text", "shared", "approved", "approved_by", "changed_at")
    readonly_fields = ("robot", "author", "text", "approved", "approved_by", "changed_at", "shared")
    actions = ("take_in", "take_out")

    def has_add_permission(self, request: HttpRequest) -> bool:
        """Programs are written in the console."""
        return False

    @admin.action(description="Take into the gallery", permissions=["change"])
    def take_in(self, request: HttpRequest, queryset: Any) -> None:
        """Approve the chosen programs."""
        self._decide(request, queryset, True)

    @admin.action(description="Take out of the gallery", permissions=["change"])
    def take_out(self, request: HttpRequest, queryset: Any) -> None:
        """Withdraw the approval of the chosen programs."""
        self._decide(request, queryset, False)

    def _decide(self, request: HttpRequest, queryset: Any, approved: bool) -> None:
        words = ("In the gallery", "There before") if approved else ("Out of the gallery", "Not there before")
        self.act_on(request, queryset, lambda one: programs.approve(one, request.user, approved), *words)


@admin.register(Command)
class CommandAdmin(ReadOnlyAdmin):
    """The command history."""

    list_display = ("id", "robot", "kind", "state", "reason", "clamped", "issued_by", "created_at", "ended_at")
    list_filter = ("robot", "state", "kind")
    date_hierarchy = "created_at"
    readonly_fields = ("clamped", "lag")

    @admin.display(description="Clamped")
    def clamped(self, command: Command) -> str:
        """Return what was sent instead of what was asked."""
        return command.clamped_words or "-"

    @admin.display(description="Age of the picture seen")
    def lag(self, command: Command) -> str:
        """Return by how much the picture that its sender saw was older than the robot's newest."""
        return "-" if command.picture_lag_s is None else f"{command.picture_lag_s:.3f} s"


@admin.register(Grant)
class GrantAdmin(ReadOnlyAdmin):
    """The history of grants."""

    list_display = ("robot", "kind", "holder", "opened_at", "ended_at", "end_reason")
    list_filter = ("robot", "kind")


@admin.register(Incident)
class IncidentAdmin(ReadOnlyAdmin):
    """The incidents of robots."""

    list_display = ("at", "robot", "code", "text", "remedy", "closed_at")
    list_filter = ("robot", "code")
    actions = ("close",)

    @admin.action(description="Mark as dealt with", permissions=["act"])
    def close(self, request: HttpRequest, queryset: Any) -> None:
        """Close the chosen incidents."""
        self.act_on(
            request, queryset, lambda one: services.close_incident(one, request.user), "Dealt with", "Dealt with before"
        )


@admin.register(Frame)
class FrameAdmin(ReadOnlyAdmin):
    """Stored pictures."""

    list_display = ("id", "robot", "taken_at", "verdict", "difference", "tries", "shown_picture")
    list_filter = ("robot", ("verdict", NamedValues))
    list_select_related = ("robot",)
    actions = ("take_down",)

    @admin.action(description="Take down: from entries, recordings and addresses", permissions=["act"])
    def take_down(self, request: HttpRequest, queryset: Any) -> None:
        """Remove the chosen pictures with all that shows them."""
        for frame in queryset.select_related("robot"):
            name = str(frame)
            self.log_deletions(request, Frame.objects.filter(pk=frame.pk))
            try:
                changed = services.take_down(frame, request.user)
            except (OSError, ValueError) as error:
                messages.error(request, f"{name} was not taken down: a recording cannot be written again ({error}).")
            else:
                messages.success(request, f"{name} was taken down; recordings changed: {changed}.")

    @admin.display(description="Picture")
    def shown_picture(self, frame: Frame) -> SafeString | str:
        """Return the picture itself."""
        return thumbnail(frame, f"Picture of {frame.robot}, {frame.taken_at:%-d %B %Y, %H:%M:%S} UTC")
