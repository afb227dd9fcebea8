"""Admin tables and filters whose parts have accessible names.

Django's tables have only column headings, which screen readers do not read with a field.
"""

from typing import Any

from django import forms
from django.contrib import admin
from django.forms.models import BaseInlineFormSet, BaseModelFormSet
from django.http import HttpRequest


def _name(form: "forms.BaseForm") -> None:
    for field in form.fields.values():
        widget: Any = getattr(field.widget, "widget", field.widget)  # the widget of a foreign key is wrapped
        if not widget.is_hidden:
            widget.attrs.setdefault("aria-label", str(field.label or ""))


class NamedRows(BaseInlineFormSet):  # type: ignore[type-arg]
    """Rows below a form."""

    def add_fields(self, form: "forms.ModelForm[Any]", index: int | None) -> None:
        """Name each field of the row, also the one that deletes it."""
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
    """A filter by the values of a text, in which the empty one has a name too."""

    def choices(self, changelist: Any) -> Any:
        """Return the choices with their words."""
        return [{**one, "display": one["display"] or "(none)"} for one in super().choices(changelist)]
