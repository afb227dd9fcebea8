"""The admin's list of recordings."""

from typing import Any

from django.contrib import admin, messages
from django.http import HttpRequest
from django.template.defaultfilters import filesizeformat
from django.utils.html import format_html
from django.utils.safestring import SafeString

from robots import services
from robots.admin.bases import ReadOnlyAdmin
from robots.models import Movie, Recording
from robots.models.recordings import OfTheDay


@admin.register(Recording)
class RecordingAdmin(ReadOnlyAdmin):
    """Recordings, the newest first; their pages replay them."""

    list_display = ("began_at", "robot", "what", "state", "reason", "bytes", "dropped", "of_the_day", "replay")
    list_filter = ("robot", "state", "of_the_day")
    list_select_related = ("robot", "grant")
    date_hierarchy = "began_at"
    actions = ("remove", "pin", "never", "by_rule")

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

    @admin.action(description="Show its movie as the movie of the day, until another is chosen", permissions=["act"])
    def pin(self, request: HttpRequest, queryset: Any) -> None:
        """Show it whatever is newer."""
        if queryset.count() > 1:
            messages.warning(request, "Choose one recording: there is one movie of the day.")
            return
        self._choose(request, queryset, OfTheDay.PINNED)

    @admin.action(description="Never show its movie as the movie of the day", permissions=["act"])
    def never(self, request: HttpRequest, queryset: Any) -> None:
        """Leave it out."""
        self._choose(request, queryset, OfTheDay.NEVER)

    @admin.action(description="Let the rule choose the movie of the day again", permissions=["act"])
    def by_rule(self, request: HttpRequest, queryset: Any) -> None:
        """Take back what was said of it."""
        self._choose(request, queryset, OfTheDay.BY_RULE)

    def _choose(self, request: HttpRequest, queryset: Any, choice: OfTheDay) -> None:
        self.act_on(
            request, queryset, lambda one: services.choose_of_the_day(one, choice, request.user),
            f"Movie of the day: {choice.label.lower()}", "That was said before",
        )  # fmt: skip


@admin.register(Movie)
class MovieAdmin(ReadOnlyAdmin):
    """Movies made of recordings."""

    list_display = ("id", "robot", "recording", "day", "kind", "state", "progress", "reason", "asked_at", "ready_at")
    list_filter = ("robot", "state", "kind")
