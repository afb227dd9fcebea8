"""Admin pages of what robots did: commands, grants, incidents, pictures, recordings; and of people's programs."""

from typing import Any

from django.contrib import admin, messages
from django.db.models import QuerySet
from django.http import HttpRequest
from django.template.defaultfilters import filesizeformat
from django.utils.formats import date_format
from django.utils.html import format_html
from django.utils.safestring import SafeString
from django.utils.timezone import localtime
from django.utils.translation import gettext, gettext_lazy

from robots import services
from robots.admin.bases import FormFieldsAdmin, GuardedAdmin, NamedValues, OneChoice, ReadOnlyAdmin, thumbnail
from robots.admin.words import NamedIncidents, NamedKinds, end_words, incident_words
from robots.models import Command, Frame, Grant, Incident, Movie, Program, Recording
from robots.models.recordings import OfTheDay
from robots.sentences import in_digits
from robots.services import programs

SAID = {
    OfTheDay.BY_RULE: gettext_lazy("Movie of the day: by the rule"),
    OfTheDay.PINNED: gettext_lazy("Movie of the day: until staff say otherwise"),
    OfTheDay.NEVER: gettext_lazy("Movie of the day: never"),
}


class WaitsForDecision(OneChoice):
    """Filters programs that people share and staff have not decided on."""

    title, parameter_name = gettext_lazy("decision"), "waits"
    choice = ("decision", gettext_lazy("not made yet"))

    def chosen(self, queryset: QuerySet[Program]) -> QuerySet[Program]:
        """Return the filtered programs."""
        return queryset.filter(pk__in=programs.to_approve().values("pk"))


@admin.register(Program)
class ProgramAdmin(FormFieldsAdmin, GuardedAdmin):
    """People's programs, reviewed for the gallery."""

    list_display = ("name", "robot", "kind", "author", "shared", "approved", "changed_at")
    list_filter = (WaitsForDecision, "robot", "shared", "approved")
    search_fields = ("name", "text")
    fields = ("robot", "kind", "author", "name", "text", "shared", "approved", "approved_by", "changed_at")
    readonly_fields = ("robot", "kind", "author", "text", "approved", "approved_by", "changed_at", "shared")
    actions = ("take_in", "take_out")

    def has_add_permission(self, request: HttpRequest) -> bool:
        """Return False: people write programs in the console."""
        return False

    @admin.action(description=gettext_lazy("Take into the gallery"), permissions=["change"])
    def take_in(self, request: HttpRequest, queryset: Any) -> None:
        """Approve the chosen programs."""
        self._decide(request, queryset, True)

    @admin.action(description=gettext_lazy("Decline, or take out of the gallery"), permissions=["change"])
    def take_out(self, request: HttpRequest, queryset: Any) -> None:
        """Decline the chosen programs, or withdraw their approval."""
        self._decide(request, queryset, False)

    def _decide(self, request: HttpRequest, queryset: Any, approved: bool) -> None:
        taken = (gettext_lazy("In the gallery"), gettext_lazy("There before"))
        declined = (gettext_lazy("Not in the gallery"), gettext_lazy("Decided before"))
        words = taken if approved else declined
        self.act_on(request, queryset, lambda one: programs.approve(one, request.user, approved), *words)


@admin.register(Command)
class CommandAdmin(ReadOnlyAdmin):
    """The command history."""

    list_display = ("id", "robot", "kind", "state", "reason", "clamped", "issued_by", "created_at", "ended_at")
    sentences = ("reason",)
    words = {"kind": lambda command: command.words}
    list_filter = ("robot", "state", ("kind", NamedKinds))
    date_hierarchy = "created_at"
    readonly_fields = ("clamped", "lag")

    @admin.display(description=gettext_lazy("Clamped"))
    def clamped(self, command: Command) -> str:
        """Return the values that were sent instead of the requested ones."""
        return command.clamped_words or "-"

    @admin.display(description=gettext_lazy("Age of the picture seen"))
    def lag(self, command: Command) -> str:
        """Return how much older the picture was that the sender saw than the robot's newest one."""
        return "-" if command.picture_lag_s is None else f"{in_digits(command.picture_lag_s)} s"


@admin.register(Grant)
class GrantAdmin(ReadOnlyAdmin):
    """The history of grants."""

    list_display = ("robot", "kind", "holder", "opened_at", "ended_at", "end_reason")
    words = {"end_reason": end_words}
    list_filter = ("robot", "kind")


@admin.register(Incident)
class IncidentAdmin(ReadOnlyAdmin):
    """The incidents of robots."""

    list_display = ("at", "robot", "text", "remedy", "closed_at")
    sentences = ("text", "remedy")
    words = {"code": lambda incident: incident_words(incident.code)}
    list_filter = ("robot", ("code", NamedIncidents))
    actions = ("close",)

    @admin.action(description=gettext_lazy("Mark as dealt with"), permissions=["act"])
    def close(self, request: HttpRequest, queryset: Any) -> None:
        """Close the chosen incidents."""
        self.act_on(
            request,
            queryset,
            lambda one: services.close_incident(one, request.user),
            gettext_lazy("Dealt with"),
            gettext_lazy("Dealt with before"),
        )


@admin.register(Frame)
class FrameAdmin(ReadOnlyAdmin):
    """Stored pictures."""

    list_display = ("id", "robot", "taken_at", "verdict", "difference", "tries", "shown_picture")
    sentences = ("verdict",)
    list_filter = ("robot", ("verdict", NamedValues))
    list_select_related = ("robot",)
    actions = ("take_down",)

    @admin.action(description=gettext_lazy("Take down: from entries, recordings and addresses"), permissions=["act"])
    def take_down(self, request: HttpRequest, queryset: Any) -> None:
        """Remove the chosen pictures and everything that shows them."""
        for frame in queryset.select_related("robot"):
            name = str(frame)
            self.log_deletions(request, Frame.objects.filter(pk=frame.pk))
            try:
                changed = services.take_down(frame, request.user)
            except (OSError, ValueError) as error:
                words = gettext("{picture} was not taken down: a recording cannot be written again ({error}).")
                messages.error(request, words.format(picture=name, error=error))
            else:
                words = gettext("{picture} was taken down; recordings changed: {count}.")
                messages.success(request, words.format(picture=name, count=changed))

    @admin.display(description=gettext_lazy("Picture"))
    def shown_picture(self, frame: Frame) -> SafeString | str:
        """Return the picture itself."""
        at = date_format(localtime(frame.taken_at), "DATETIME_FORMAT")
        return thumbnail(frame, gettext("Picture of {robot}, {time}").format(robot=frame.robot, time=at))


@admin.register(Recording)
class RecordingAdmin(ReadOnlyAdmin):
    """Recordings, the newest first; their pages replay them."""

    list_display = ("began_at", "robot", "what", "state", "reason", "bytes", "dropped", "of_the_day", "replay")
    sentences = ("reason",)
    list_filter = ("robot", "state", "of_the_day")
    list_select_related = ("robot", "grant")
    date_hierarchy = "began_at"
    actions = ("remove", "pin", "never", "by_rule")

    @admin.display(description=gettext_lazy("Of a"))
    def what(self, recording: Recording) -> str:
        """Return turn or job."""
        return recording.grant.get_kind_display()

    @admin.display(description=gettext_lazy("Size"), ordering="size")
    def bytes(self, recording: Recording) -> str:
        """Return the size in words."""
        return filesizeformat(recording.size)

    @admin.display(description=gettext_lazy("Page"))
    def replay(self, recording: Recording) -> SafeString:
        """Return a link to its page."""
        return format_html('<a href="{}">{}</a>', recording.get_absolute_url(), gettext("Replay"))

    @admin.action(description=gettext_lazy("Remove the recording"), permissions=["act"])
    def remove(self, request: HttpRequest, queryset: Any) -> None:
        """Remove files and movies; the rows stay and show this."""
        self.act_on(
            request,
            queryset,
            lambda one: services.remove_recording(one, request.user),
            gettext_lazy("Removed"),
            gettext_lazy("Removed before"),
        )

    @admin.action(
        description=gettext_lazy("Show its movie as the movie of the day, until another is chosen"), permissions=["act"]
    )
    def pin(self, request: HttpRequest, queryset: Any) -> None:
        """Show its movie even if there are newer ones."""
        if queryset.count() > 1:
            messages.warning(request, gettext("Choose one recording: there is one movie of the day."))
            return
        self._choose(request, queryset, OfTheDay.PINNED)

    @admin.action(description=gettext_lazy("Never show its movie as the movie of the day"), permissions=["act"])
    def never(self, request: HttpRequest, queryset: Any) -> None:
        """Leave its movie out."""
        self._choose(request, queryset, OfTheDay.NEVER)

    @admin.action(description=gettext_lazy("Let the rule choose the movie of the day again"), permissions=["act"])
    def by_rule(self, request: HttpRequest, queryset: Any) -> None:
        """Let the rule decide about its movie again."""
        self._choose(request, queryset, OfTheDay.BY_RULE)

    def _choose(self, request: HttpRequest, queryset: Any, choice: OfTheDay) -> None:
        self.act_on(
            request, queryset, lambda one: services.choose_of_the_day(one, choice, request.user),
            SAID[choice], gettext_lazy("That was said before"),
        )  # fmt: skip


@admin.register(Movie)
class MovieAdmin(ReadOnlyAdmin):
    """Movies made of recordings."""

    list_display = ("id", "robot", "recording", "day", "kind", "state", "progress", "reason", "asked_at", "ready_at")
    sentences = ("reason",)
    list_filter = ("robot", "state", "kind")
