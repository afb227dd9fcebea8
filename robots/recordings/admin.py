"""The admin's list of recordings."""

from typing import Any

from django.contrib import admin
from django.http import HttpRequest
from django.template.defaultfilters import filesizeformat
from django.utils.html import format_html
from django.utils.safestring import SafeString

from robots import services
from robots.history import Kept
from robots.models import Movie, Recording


@admin.register(Recording)
class RecordingAdmin(Kept):
    """Recordings, the newest first; their pages replay them."""

    list_display = ("began_at", "robot", "what", "state", "reason", "bytes", "dropped", "replay")
    list_filter = ("robot", "state")
    list_select_related = ("robot", "grant")
    date_hierarchy = "began_at"
    actions = ("remove",)

    @admin.display(description="Of a")
    def what(self, recording: Recording) -> str:
        """Return turn or job."""
        return recording.grant.get_kind_display()

    @admin.display(description="Size", ordering="size")
    def bytes(self, recording: Recording) -> str:
        """Return the size in words."""
        return filesizeformat(recording.size)

    @admin.display(description="Page")
    def replay(self, recording: Recording) -> SafeString:
        """Return a link to its page."""
        return format_html('<a href="{}">Replay</a>', recording.get_absolute_url())

    @admin.action(description="Remove the recording", permissions=["act"])
    def remove(self, request: HttpRequest, queryset: Any) -> None:
        """Remove files and movies; the rows say so."""
        self.act_on(
            request, queryset, lambda one: services.remove_recording(one, request.user), "Removed", "Removed before"
        )


@admin.register(Movie)
class MovieAdmin(Kept):
    """Movies made of recordings."""

    list_display = ("id", "robot", "recording", "day", "kind", "state", "progress", "reason", "asked_at", "ready_at")
    list_filter = ("robot", "state", "kind")
