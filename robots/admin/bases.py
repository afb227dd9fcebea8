"""Base classes of admin pages: guarded actions, read-only records, tables with accessible names, partial saving."""

from collections.abc import Callable, Iterable, Mapping
from datetime import datetime
from http import HTTPStatus
from typing import Any

from django import forms
from django.contrib import admin, messages
from django.contrib.admin.utils import model_ngettext
from django.core.exceptions import PermissionDenied
from django.db import models
from django.db.models import QuerySet
from django.forms.models import BaseInlineFormSet, BaseModelFormSet
from django.http import HttpRequest, HttpResponse
from django.shortcuts import redirect
from django.utils.html import format_html
from django.utils.safestring import SafeString
from django.utils.timezone import localtime
from django.utils.translation import gettext

from robots.kit.contract.errors import RobotError
from robots.models import Frame
from robots.sentences import english, in_digits, translate


def comes_from_first(request: HttpRequest) -> bool:
    """Return whether the form stands on the admin's first page, to which its answer leads back."""
    return request.method == "POST" and request.POST.get("from") == "first"


def back_to(request: HttpRequest, *otherwise: Any) -> HttpResponse:
    """Return the redirection to the page whose form was sent: the admin's first page, or `otherwise`."""
    return redirect("admin:index") if comes_from_first(request) else redirect(*otherwise)


class OneChoice(admin.SimpleListFilter):
    """A filter of a list with one choice, `choice`: its word in the address, and what the page says."""

    choice: tuple[str, Any]

    def lookups(self, request: HttpRequest, model_admin: Any) -> list[tuple[str, Any]]:
        """Return the choice."""
        return [self.choice]

    def queryset(self, request: HttpRequest, queryset: QuerySet[Any]) -> QuerySet[Any]:
        """Return the rows, filtered if the choice is made."""
        return self.chosen(queryset) if self.value() == self.choice[0] else queryset

    def chosen(self, queryset: QuerySet[Any]) -> QuerySet[Any]:
        """Return the filtered rows."""
        raise NotImplementedError


class GuardedAdmin(admin.ModelAdmin):  # type: ignore[type-arg]
    """A list whose actions answer 403 to people without the permission; Django would ignore the action silently."""

    def changelist_view(self, request: HttpRequest, extra_context: dict[str, Any] | None = None) -> HttpResponse:
        """Show the list, or carry out an action on it."""
        wanted = request.POST.get("action", "")
        known = {getattr(action, "__name__", action) for action in self.actions or ()} | {"delete_selected"}
        if wanted in known and wanted not in self.get_actions(request):
            raise PermissionDenied
        answer = super().changelist_view(request, extra_context)
        return back_to(request) if answer.status_code == HTTPStatus.FOUND and comes_from_first(request) else answer

    def history_view(self, request: HttpRequest, object_id: str, extra_context: Any = None) -> HttpResponse:
        """Show the history of a row; what actions have noted is stored in English, line by line."""
        answer = super().history_view(request, object_id, extra_context)
        for one in getattr(answer, "context_data", {}).get("action_list", ()):
            one.change_message = " ".join(gettext(line) for line in one.change_message.splitlines() if line)
        return answer

    def act_on(
        self, request: HttpRequest, chosen: Iterable[Any], verb: Callable[[Any], bool], word: Any, rest: Any
    ) -> None:
        """Carry out a verb on each chosen row, note it in the row's history, and show how many rows changed.

        `verb` returns whether it changed the row; `rest` is the text for rows that it did not change. Both texts are
        lazy: the row's history has the first in English. A refusal is shown with its row.
        """
        done = others = 0
        for one in chosen:
            try:
                changed = verb(one)
            except RobotError as error:
                messages.warning(request, f"{one}: {translate(error)}")
                continue
            if changed:
                self.log_change(request, one, english(word))
            done, others = done + changed, others + (not changed)
        counts = [(count, text) for count, text in ((done, word), (others, rest)) if count]
        words = gettext("{done}: {count} {rows}.")
        sentences = [words.format(done=text, count=n, rows=model_ngettext(self.opts, n)) for n, text in counts]
        if sentences:
            messages.add_message(request, messages.SUCCESS if done else messages.INFO, " ".join(sentences))


class ReadOnlyAdmin(GuardedAdmin):
    """A record that the admin only shows."""

    sentences: tuple[str, ...] = ()  # fields with sentences of the portal, which are stored in English
    words: Mapping[str, Callable[[Any], str]] = {}  # fields with codes, and what says a row's code in words

    def get_list_display(self, request: HttpRequest) -> Any:
        """Return the columns; sentences and numbers are in the reader's language."""
        return [self._in_words(name) for name in super().get_list_display(request)]

    def get_fields(self, request: HttpRequest, obj: Any = None) -> Any:
        """Return the fields of the page; sentences and numbers are in the reader's language."""
        return [self._in_words(name) for name in super().get_fields(request, obj)]

    def _in_words(self, name: Any) -> Any:
        field: Any = next((one for one in self.opts.concrete_fields if one.name == name), None)
        is_number = isinstance(field, models.FloatField)
        if name not in (*self.sentences, *self.words) and not is_number:
            return name

        @admin.display(description=field.verbose_name, ordering=name)
        def shown(row: Any) -> str:
            value = getattr(row, name)
            if is_number:
                return "-" if value is None else in_digits(value)
            return (self.words[name](row) if name in self.words else translate(value)) or "-"

        shown.__name__ = name  # it is in the column's class
        return shown

    def has_act_permission(self, request: HttpRequest) -> bool:
        """Return whether the person may act on robots and turns; a lower permission is enough to see them."""
        return request.user.has_perm("robots.change_robot")

    def _never(self, request: HttpRequest, obj: Any = None) -> bool:
        return False

    has_add_permission = has_change_permission = has_delete_permission = _never


class FormFieldsAdmin(admin.ModelAdmin):  # type: ignore[type-arg]
    """A page that writes only the fields of its form when it changes a row.

    Django writes the whole row as it was read, which would undo a stop between reading and writing.
    """

    also_saved: tuple[str, ...] = ()  # fields that follow from the form and are not in it

    def save_model(self, request: HttpRequest, obj: Any, form: Any, change: bool) -> None:
        """Save a new row completely, and of a changed row only the fields of the form."""
        if not change:
            super().save_model(request, obj, form, change)
            return
        shown = {name for name, field in form.fields.items() if not field.disabled}
        columns = {field.name for field in obj._meta.concrete_fields if not field.primary_key}
        obj.save(update_fields=columns & shown | {*self.also_saved})


# Django's tables have only column headings, which screen readers do not read together with a field.
def _name(form: "forms.BaseForm") -> None:
    for field in form.fields.values():
        widget: Any = getattr(field.widget, "widget", field.widget)  # the widget of a foreign key is wrapped
        if not widget.is_hidden:
            widget.attrs.setdefault("aria-label", str(field.label or ""))


class NamedRows(BaseInlineFormSet):  # type: ignore[type-arg]
    """Rows below a form."""

    def add_fields(self, form: "forms.ModelForm[Any]", index: int | None) -> None:
        """Name each field of the row, also the check box that deletes it."""
        super().add_fields(form, index)
        _name(form)


class NamedList(BaseModelFormSet):  # type: ignore[type-arg]
    """Rows of a list that is edited in place."""

    def add_fields(self, form: "forms.ModelForm[Any]", index: int | None) -> None:
        """Name each field of the row."""
        super().add_fields(form, index)
        _name(form)


class NamedRowsAdmin(admin.ModelAdmin):  # type: ignore[type-arg]
    """A list that is edited in place and names its fields."""

    def get_changelist_formset(self, request: HttpRequest, **kwargs: Any) -> Any:
        """Return the form set of the rows."""
        return super().get_changelist_formset(request, formset=NamedList, **kwargs)


class NamedInline(admin.TabularInline):  # type: ignore[type-arg]
    """A table of rows that each name their fields."""

    formset = NamedRows
    template = "admin/edit_inline/named.html"


class NamedValues(admin.AllValuesFieldListFilter):
    """A filter by the values of a text field that also names the empty value."""

    def choices(self, changelist: Any) -> Any:
        """Return the choices with their words."""
        every, *values = super().choices(changelist)
        yield every
        for one in values:
            shown = str(one["display"])
            value, *count = shown.rpartition(" (") if changelist.add_facets else (shown,)
            yield {**one, "display": "".join((self.named(value) or gettext("(none)"), *count))}

    def named(self, value: str) -> str:
        """Return the words of a value, which may be empty."""
        return translate(value)


def clock_time(at: datetime) -> str:
    """Return a time without its day, in the reader's zone."""
    return f"{localtime(at):%H:%M:%S}"


def thumbnail(frame: Frame | None, words: str) -> SafeString | str:
    """Return a small, lazily loaded picture that links to the full one; a dash if there is none."""
    if frame is None:
        return "-"
    return format_html(
        '<a href="{0}"><img class="farhand-thumbnail" src="{0}" alt="{1}" loading="lazy"></a>', frame.url, words
    )
