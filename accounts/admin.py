"""Admin pages of people, clearances and the question bank."""

from collections.abc import Callable
from typing import Any

from allauth.account.admin import EmailAddressAdmin
from allauth.account.models import EmailAddress
from django import forms
from django.contrib import admin, messages
from django.contrib.admin.helpers import ActionForm
from django.contrib.admin.utils import unquote
from django.contrib.auth.admin import GroupAdmin, UserAdmin
from django.contrib.auth.forms import AdminUserCreationForm, UserChangeForm
from django.contrib.auth.models import Group
from django.core.exceptions import PermissionDenied
from django.db import DataError
from django.http import HttpRequest, HttpResponse
from django.utils.translation import gettext, gettext_lazy, ngettext

from accounts import admin_words, handles, staff
from accounts.bank import load_bank
from accounts.models import Attempt, Choice, Clearance, Question, User
from accounts.staff import drives_more, may_do_more
from robots.admin.bases import FormFieldsAdmin, GuardedAdmin, NamedInline, ReadOnlyAdmin
from robots.admin.verbs import after_adding
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import RobotError
from robots.models import Robot
from robots.sentences import english, translate


@after_adding
def load_questions(robot: Robot) -> str:
    """Load the questions of the clearance test from the robot's package. Return what staff should know."""
    try:
        added = load_bank(robot)
    except OSError:
        added = 0
    except (DataError, LookupError, TypeError, ValueError) as error:  # a package of somebody else
        words = gettext(
            "clearance.toml of its package cannot be read ({error}); write questions under Clearance questions."
        )
        return words.format(error=repr(error))
    if not added and (kept := Question.objects.filter(robot=robot).count()):
        words = ngettext(
            "It has {count} question for the clearance test, and its package brings no others.",
            "It has {count} questions for the clearance test, and its package brings no others.",
            kept,
        )
        return words.format(count=kept)
    if not added:
        return gettext("Its package brings no questions for the clearance test; write them under Clearance questions.")
    words = ngettext(
        "{count} question for the clearance test came with its package; read it under Clearance questions.",
        "{count} questions for the clearance test came with its package; read them under Clearance questions.",
        added,
    )
    return words.format(count=added)


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

    note = forms.CharField(required=False, max_length=staff.LONGEST, label=gettext_lazy("Note to the person:"))


def _decides(user: Any, clearance: Clearance | None) -> bool:
    if clearance is None or user.is_superuser:
        return True
    return clearance.user_id != user.pk and not may_do_more(clearance.user, user)


class ClearanceForm(forms.ModelForm):  # type: ignore[type-arg]
    """A clearance of another person, who has no more rights than the user."""

    by: Any  # the person who fills it in

    def clean_user(self) -> User:
        """Return the person."""
        person: User = self.cleaned_data["user"]
        if person.pk == self.by.pk and not self.by.is_superuser:
            raise forms.ValidationError(gettext("Nobody clears themselves; ask other staff."))
        if may_do_more(person, self.by):
            words = gettext("This person has rights that you have not; a superuser decides on this.")
            raise forms.ValidationError(words)
        return person


@admin.register(Clearance)
class ClearanceAdmin(FormFieldsAdmin, GuardedAdmin):
    """Clearances; they are withdrawn and reopened by actions with a note. Nobody decides on their own."""

    form = ClearanceForm

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

    def get_form(self, request: HttpRequest, obj: Any = None, change: bool = False, **kwargs: Any) -> Any:
        """Return the form with the person who fills it in."""
        return type("ClearanceForm", (super().get_form(request, obj, change, **kwargs),), {"by": request.user})

    def has_change_permission(self, request: HttpRequest, obj: Any = None) -> bool:
        """Return False for one's own clearance and for a person with more rights."""
        return _decides(request.user, obj) and super().has_change_permission(request, obj)

    def has_delete_permission(self, request: HttpRequest, obj: Any = None) -> bool:
        """Return False for one's own clearance and for a person with more rights."""
        return _decides(request.user, obj) and super().has_delete_permission(request, obj)

    @admin.action(description=gettext_lazy("Withdraw the clearance (with a note)"), permissions=["change"])
    def withdraw(self, request: HttpRequest, queryset: Any) -> None:
        """Withdraw the chosen clearances."""
        self._decide(request, queryset, staff.withdraw, gettext_lazy("withdrawn"))

    @admin.action(
        description=gettext_lazy("Lift the withdrawal: the test may be taken again (with a note)"),
        permissions=["change"],
    )
    def lift(self, request: HttpRequest, queryset: Any) -> None:
        """Let the chosen people take the test again."""
        self._decide(request, queryset, staff.lift, gettext_lazy("withdrawal lifted"))

    def _decide(self, request: HttpRequest, queryset: Any, verb: Callable[..., bool], word: Any) -> None:
        note = request.POST.get("note", "")
        for clearance in queryset:
            try:
                done = verb(clearance, request.user, note, SYSTEM.now())
            except RobotError as error:
                messages.error(request, translate(error))
                return
            if done:
                self.log_change(request, clearance, f"{english(word)}: {note.strip()}")
            said = word if done else gettext("nothing to do")
            messages.info(request, f"{clearance}: {said}.")


@admin.register(Attempt)
class AttemptAdmin(ReadOnlyAdmin):
    """The tests that people took."""

    list_display = ("user", "robot", "started_at", "score", "passed")
    list_filter = ("robot", "passed")
    fields = ("user", "robot", "drawn", "started_at", "finished_at", "answers", "score", "passed")


class HandleRules(forms.ModelForm):  # type: ignore[type-arg]
    """Checks a handle that is new or changed; an older handle stays valid."""

    def clean_username(self) -> str:
        """Return the handle in its stored form."""
        handle = handles.normal(self.cleaned_data["username"])
        if handle != self.initial.get("username"):
            handles.validate(handle)
            if handles.is_taken(handle, but=self.instance.pk):
                raise forms.ValidationError(gettext("That handle is taken, or looks like one that is taken."))
        return handle


class PersonForm(HandleRules, UserChangeForm):  # type: ignore[type-arg]
    """An account."""


class NewPersonForm(HandleRules, AdminUserCreationForm):  # type: ignore[type-arg]
    """A new account."""


@admin.register(User)
class PersonAdmin(FormFieldsAdmin, UserAdmin):  # type: ignore[type-arg]
    """People. Only a superuser gives rights, and nobody changes an account with more rights than their own."""

    form, add_form = PersonForm, NewPersonForm
    also_saved = ("handle_key",)
    fieldsets = (*(UserAdmin.fieldsets or ()), (gettext_lazy("More time"), {"fields": ("turn_factor",)}))

    def get_readonly_fields(self, request: HttpRequest, obj: Any = None) -> tuple[str, ...]:
        """Return the locked fields: rights, the own length of turns, and the mail address of who drives more.

        With a new password for that address, others could drive more than they may.
        """
        locked = () if request.user.is_superuser else ("is_staff", "is_superuser", "groups", "user_permissions")
        email = ("email",) if obj is not None and drives_more(obj, request.user) else ()
        own = ("turn_factor",) if obj is not None and obj.pk == request.user.pk and locked else ()
        return (*super().get_readonly_fields(request, obj), *locked, *email, *own)

    def get_fieldsets(self, request: HttpRequest, obj: Any = None) -> Any:
        """Return the groups of fields, without the password and its button if the user may not set it."""
        groups = super().get_fieldsets(request, obj)
        if obj is None or (self.has_change_permission(request, obj) and not drives_more(obj, request.user)):
            return groups
        return [(name, {**part, "fields": [f for f in part["fields"] if f != "password"]}) for name, part in groups]

    def has_change_permission(self, request: HttpRequest, obj: Any = None) -> bool:
        """Return False for an account with more rights: with a new password or address, others could use it."""
        return not (obj and may_do_more(obj, request.user)) and super().has_change_permission(request, obj)

    def has_delete_permission(self, request: HttpRequest, obj: Any = None) -> bool:
        """Return False for an account with more rights."""
        return not (obj and may_do_more(obj, request.user)) and super().has_delete_permission(request, obj)

    def get_deleted_objects(self, objs: Any, request: HttpRequest) -> Any:
        """Let a person who may delete the account also delete its rows, even those that are kept as history."""
        shown, counts, needed, protected = super().get_deleted_objects(objs, request)
        return shown, counts, needed & {self.opts.verbose_name}, protected

    def user_change_password(self, request: HttpRequest, id: str, form_url: str = "") -> HttpResponse:
        """Set a password, but not of a person with a clearance that the user has not."""
        person = self.get_object(request, unquote(id))
        if person is not None and drives_more(person, request.user):
            raise PermissionDenied
        return super().user_change_password(request, id, form_url)


class ForSuperusers(admin.ModelAdmin):  # type: ignore[type-arg]
    """A page that staff with the permission may look at, and superusers change."""

    def get_actions(self, request: HttpRequest) -> dict[str, Any]:
        """Return the actions for superusers; others have none."""
        return super().get_actions(request) if request.user.is_superuser else {}

    def _is_superuser(self, request: HttpRequest, obj: Any = None) -> bool:
        return bool(request.user.is_superuser)

    has_add_permission = has_change_permission = has_delete_permission = _is_superuser

    def has_view_permission(self, request: HttpRequest, obj: Any = None) -> bool:
        """Return whether the person has any permission of the model."""
        label, name = self.opts.app_label, self.opts.model_name
        return any(request.user.has_perm(f"{label}.{verb}_{name}") for verb in ("view", "change", "add", "delete"))


admin.site.unregister((Group, EmailAddress))
admin_words.install()


@admin.register(Group)
class RightsAdmin(ForSuperusers, GroupAdmin):
    """Groups. They give rights, so a person who could edit their own group would give rights to themselves."""


@admin.register(EmailAddress)
class AddressAdmin(ForSuperusers, EmailAddressAdmin):  # type: ignore[misc]
    """Verified addresses. They get the link to a new password, so an own address at another account would open it."""

    @admin.action(description=gettext_lazy("Mark as verified"))
    def make_verified(self, request: HttpRequest, queryset: Any) -> None:
        """Mark the chosen addresses. allauth reports those that were not marked before."""
        if before := queryset.filter(verified=True).count():
            messages.info(request, gettext("Verified before: {count}.").format(count=before))
        super().make_verified(request, queryset)
