"""Admin pages: moderation of the log, and the survey."""

from typing import Any

from django.contrib import admin
from django.db.models import F, QuerySet
from django.http import HttpRequest
from django.utils.safestring import SafeString
from django.utils.translation import gettext, gettext_lazy

from operatorlog import finds_admin as finds_admin
from operatorlog import services
from operatorlog.models import Entry, HidingReason, SurveyAnswer, SurveyQuestion, SurveyResponse, Visibility
from operatorlog.review_admin import ReviewAdmin
from robots.admin.bases import NamedInline, NamedRowsAdmin, OneChoice, thumbnail
from robots.kit.clock import SYSTEM
from robots.people import shown_name


class EditedSince(OneChoice):
    """Filters entries that were changed after moderation; a featured entry loses its mark by such a change."""

    title, parameter_name = gettext_lazy("changed"), "edited"
    choice = ("since", gettext_lazy("since a moderator looked"))

    def chosen(self, queryset: QuerySet[Entry]) -> QuerySet[Entry]:
        """Return the filtered entries."""
        return queryset.filter(edited_at__gt=F("moderated_at"))


class WaitsForReview(OneChoice):
    """Filters entries at which a moderator has to look."""

    title, parameter_name = gettext_lazy("review"), "waits"
    choice = ("review", gettext_lazy("not looked at yet"))

    def chosen(self, queryset: QuerySet[Entry]) -> QuerySet[Entry]:
        """Return the filtered entries."""
        return queryset.filter(pk__in=services.to_review().values("pk"))


@admin.register(Entry)
class EntryAdmin(ReviewAdmin):
    """Publish, feature, or hide entries with a reason."""

    list_display = ("written_at", "picture", "author", "robot", "text", "visibility_said", "edited_at")
    list_select_related = ("author", "robot", "frame__robot")
    list_filter = (WaitsForReview, "visibility", EditedSince, "robot")
    search_fields = ("text", "author__username")
    actions = ("publish", "feature")

    def has_add_permission(self, request: HttpRequest) -> bool:
        """Return False: operators write entries after their turn."""
        return False

    def has_delete_permission(self, request: HttpRequest, obj: Entry | None = None) -> bool:
        """Return False for a hidden entry: without it, the turn's pictures and recording would be shown again."""
        hidden = obj is not None and obj.visibility == Visibility.HIDDEN
        return not hidden and super().has_delete_permission(request, obj)

    @admin.action(description=gettext_lazy("Publish"), permissions=["change"])
    def publish(self, request: HttpRequest, queryset: Any) -> None:
        """Publish the chosen entries."""
        self._moderate(request, queryset, Visibility.PUBLISHED)

    @admin.action(description=gettext_lazy("Feature"), permissions=["change"])
    def feature(self, request: HttpRequest, queryset: Any) -> None:
        """Feature the chosen entries."""
        self._moderate(request, queryset, Visibility.FEATURED)

    def _moderate(self, request: HttpRequest, queryset: Any, wanted: Visibility) -> None:
        def moderated(entry: Entry) -> bool:
            changed = entry.visibility != wanted
            services.moderate(entry, request.user, wanted, "", SYSTEM.now())  # unchanged, it notes a moderator's look
            return changed

        before = {
            Visibility.PUBLISHED: gettext_lazy("Published before, looked at again"),
            Visibility.FEATURED: gettext_lazy("Featured before, looked at again"),
        }
        self.act_on(request, queryset, moderated, wanted.label, before[wanted])

    @admin.display(description=gettext_lazy("Picture"))
    def picture(self, entry: Entry) -> SafeString | str:
        """Return the entry's picture."""
        words = gettext("Picture from the turn of {author} on {robot}")
        return thumbnail(entry.frame, words.format(author=shown_name(entry.author_name), robot=entry.robot))

    @admin.display(description=gettext_lazy("Visibility"), ordering="visibility")
    def visibility_said(self, entry: Entry) -> str:
        """Return who reads the entry, and why it is hidden if it is."""
        return ": ".join(filter(None, (entry.get_visibility_display(), entry.why_hidden)))


@admin.register(HidingReason)
class HidingReasonAdmin(NamedRowsAdmin):
    """The reasons from which moderators choose."""

    list_display = ("text", "position", "active")
    list_editable = ("position", "active")


@admin.register(SurveyQuestion)
class SurveyQuestionAdmin(NamedRowsAdmin):
    """The questions after a turn or a job."""

    list_display = ("prompt", "kind", "after", "position", "active")
    list_editable = ("after", "position", "active")


class AnswerInline(NamedInline):
    """One person's answers."""

    model = SurveyAnswer
    extra = 0
    fields = readonly_fields = ("question", "value")
    can_delete = False


@admin.register(SurveyResponse)
class SurveyResponseAdmin(admin.ModelAdmin):  # type: ignore[type-arg]
    """People's answers; plots and CSV are at /survey/results/."""

    list_display = ("__str__", "at")
    inlines = (AnswerInline,)
    readonly_fields = ("turn", "robot", "at")

    def has_add_permission(self, request: HttpRequest) -> bool:
        """Return False: people answer on the page of their turn or job."""
        return False
