"""Admin pages that save what their form contains, and nothing else of the row."""

from typing import Any

from django.contrib import admin
from django.http import HttpRequest


class FormFieldsAdmin(admin.ModelAdmin):  # type: ignore[type-arg]
    """A page that writes only the fields of its form when a row is changed.

    Django writes the whole row, as it was read: a stop that came between reading and writing would be undone.
    """

    also_saved: tuple[str, ...] = ()  # fields that follow from the form without being shown

    def save_model(self, request: HttpRequest, obj: Any, form: Any, change: bool) -> None:
        """Save a new row whole, a changed one as far as the form goes."""
        if not change:
            super().save_model(request, obj, form, change)
            return
        shown = {name for name, field in form.fields.items() if not field.disabled}
        columns = {field.name for field in obj._meta.concrete_fields if not field.primary_key}
        obj.save(update_fields=columns & shown | {*self.also_saved})
