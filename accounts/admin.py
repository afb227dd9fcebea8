"""People, clearances and the question bank."""

from django.contrib import admin
from django.contrib.auth.admin import UserAdmin

from accounts.models import Attempt, Choice, Clearance, Question, User


class ChoiceInline(admin.TabularInline):  # type: ignore[type-arg]
    """The answers of a question."""

    model = Choice
    extra = 0
    min_num = 2


@admin.register(Question)
class QuestionAdmin(admin.ModelAdmin):  # type: ignore[type-arg]
    """The question bank."""

    list_display = ("text", "robot", "active")
    list_filter = ("robot", "active")
    inlines = (ChoiceInline,)


@admin.register(Clearance)
class ClearanceAdmin(admin.ModelAdmin):  # type: ignore[type-arg]
    """Who may drive what."""

    list_display = ("user", "robot", "level", "granted_at", "revoked_at")
    list_filter = ("robot",)
    autocomplete_fields = ("user",)


@admin.register(Attempt)
class AttemptAdmin(admin.ModelAdmin):  # type: ignore[type-arg]
    """The tests that were taken."""

    list_display = ("user", "robot", "started_at", "score", "passed")
    readonly_fields = ("user", "robot", "drawn", "started_at", "finished_at", "answers", "score", "passed")


admin.site.register(User, UserAdmin)
