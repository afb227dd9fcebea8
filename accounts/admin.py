"""Admin pages of people, clearances and the question bank."""

from collections.abc import Callable
from typing import Any

from django import forms
from django.contrib import admin, messages
from django.contrib.admin.helpers import ActionForm
from django.contrib.auth.admin import UserAdmin
from django.contrib.auth.forms import AdminUserCreationForm, UserChangeForm
from django.db import DataError
from django.http import HttpRequest

from accounts import handles, staff
from accounts.bank import load_bank
from accounts.models import Attempt, Choice, Clearance, Question, User
from robots.added import on_added
from robots.clock import SYSTEM
from robots.drivers.errors import RobotError
from robots.history import Guarded, Kept
from robots.inlines import NamedInline
from robots.models import Robot
from robots.saving import FormFieldsAdmin


@on_added
def load_questions(robot: Robot) -> str:
    """Load the questions of the clearance test that the robot's package brings. Return what staff should know."""
    try:
        added = load_bank(robot)
    except OSError:
        added = 0
    except (DataError, LookupError, TypeError, ValueError) as error:  # a package of somebody else
        return f"clearance.toml of its package cannot be read ({error!r}); write questions under Clearance questions."
    if not added and (kept := Question.objects.filter(robot=robot).count()):
        return f"It has {kept} questions for the clearance test, and its package brings no others."
    if not added:
        return "Its package brings no questions for the clearance test; write them under Clearance questions."
    return f"{added} questions for the clearance test came with its package; read them under Clearance questions."


class ChoiceInline(NamedInline):
    """The answers of a question."""

    model = Choice
    extra = 0
    min_num = 2


@admin.register(Question)
class QuestionAdmin(admin.ModelAdmin):  # type: ignore[type-arg]
    """The question bank."""

    list_display = ("text", "robot", "topic", "active")
    list_filter = ("robot", "active")
    inlines = (ChoiceInline,)


class NoteForm(ActionForm):
    """An action with a note."""

    note = forms.CharField(required=False, max_length=staff.LONGEST, label="Note to the person:")


@admin.register(Clearance)
class ClearanceAdmin(FormFieldsAdmin, Guarded):
    """Clearances; they are withdrawn and reopened by actions with a note."""

    list_display = ("user", "robot", "level", "granted_at", "revoked_at", "note", "lifted_at")
    list_filter = ("robot",)
    autocomplete_fields = ("user",)
    fields = ("user", "robot", "level", "granted_at", "revoked_at", "note", "lifted_at")
    readonly_fields = ("revoked_at", "note", "lifted_at")
    action_form = NoteForm
    actions = ("withdraw", "lift")

    def get_changeform_initial_data(self, request: HttpRequest) -> dict[str, Any]:
        """Start a new clearance today."""
        return {"granted_at": SYSTEM.now(), **super().get_changeform_initial_data(request)}

    @admin.action(description="Withdraw the clearance (with a note)", permissions=["change"])
    def withdraw(self, request: HttpRequest, queryset: Any) -> None:
        """Withdraw the chosen clearances."""
        self._decide(request, queryset, staff.withdraw, "withdrawn")

    @admin.action(description="Lift the withdrawal: the test may be taken again (with a note)", permissions=["change"])
    def lift(self, request: HttpRequest, queryset: Any) -> None:
        """Let the chosen people take the test again."""
        self._decide(request, queryset, staff.lift, "withdrawal lifted")

    def _decide(self, request: HttpRequest, queryset: Any, verb: Callable[..., bool], word: str) -> None:
        note = request.POST.get("note", "")
        for clearance in queryset:
            try:
                done = verb(clearance, request.user, note, SYSTEM.now())
            except RobotError as error:
                messages.error(request, str(error))
                return
            if done:
                self.log_change(request, clearance, f"{word}: {note.strip()}")
            messages.info(request, f"{clearance}: {word if done else 'nothing to do'}.")


@admin.register(Attempt)
class AttemptAdmin(Kept):
    """The tests that people took."""

    list_display = ("user", "robot", "started_at", "score", "passed")
    list_filter = ("robot", "passed")
    fields = ("user", "robot", "drawn", "started_at", "finished_at", "answers", "score", "passed")


class HandleRules(forms.ModelForm):  # type: ignore[type-arg]
    """Checks a handle that is new or changed; older handles stay."""

    def clean_username(self) -> str:
        """Return the handle in its stored form."""
        handle = handles.normal(self.cleaned_data["username"])
        if handle != self.initial.get("username"):
            handles.validate(handle)
            if handles.taken(handle, but=self.instance.pk):
                raise forms.ValidationError("That handle is taken, or looks like one that is taken.")
        return handle


class PersonForm(HandleRules, UserChangeForm):  # type: ignore[type-arg]
    """An account."""


class NewPersonForm(HandleRules, AdminUserCreationForm):  # type: ignore[type-arg]
    """A new account."""


@admin.register(User)
class PersonAdmin(FormFieldsAdmin, UserAdmin):  # type: ignore[type-arg]
    """People. Only a superuser gives rights, so that nobody can give rights to themselves."""

    form, add_form = PersonForm, NewPersonForm
    also_saved = ("handle_key",)

    def get_readonly_fields(self, request: HttpRequest, obj: Any = None) -> tuple[str, ...]:
        """Lock the fields of rights for staff who are not superusers."""
        locked = () if request.user.is_superuser else ("is_staff", "is_superuser", "groups", "user_permissions")
        return (*super().get_readonly_fields(request, obj), *locked)

    def has_change_permission(self, request: HttpRequest, obj: Any = None) -> bool:
        """Let only superusers change a superuser's account: with a new password, others could use it."""
        mine = obj is None or not obj.is_superuser or request.user.is_superuser
        return mine and super().has_change_permission(request, obj)

    def has_delete_permission(self, request: HttpRequest, obj: Any = None) -> bool:
        """Let only superusers delete a superuser."""
        mine = obj is None or not obj.is_superuser or request.user.is_superuser
        return mine and super().has_delete_permission(request, obj)
