"""The names of models and of their fields in the reader's language.

A name comes from the code, `started_at` is "started at"; a name written at each field would be a migration. So they
are marked when all models are there, and `tools/translations.py` finds them in the same way.
"""

from collections.abc import Iterator
from typing import Any

from django.apps import apps
from django.utils.translation import pgettext_lazy

ROOMS = ("robots", "accounts", "queueing", "operatorlog", "portal")
CONTEXT = "field"  # of the catalogue: a word such as "turn" has other meanings elsewhere


def translate_names() -> None:
    """Make those names texts in the reader's language."""
    for model in own_models():
        for owner, attribute, name in list(names_of(model)):
            setattr(owner, attribute, pgettext_lazy(CONTEXT, name))


def own_models() -> list[Any]:
    """Return the models of the portal's own apps."""
    return [model for model in apps.get_models() if model.__module__.split(".")[0] in ROOMS]


def names_of(model: Any) -> Iterator[tuple[Any, str, Any]]:
    """Yield owner, attribute and text of each name that is not written in the model's source."""
    options = model._meta
    written = options.original_attrs
    if "verbose_name_plural" not in written:
        yield options, "verbose_name_plural", f"{options.verbose_name_raw}s"
    if "verbose_name" not in written:
        yield options, "verbose_name", options.verbose_name
    for field in (*options.local_fields, *options.local_many_to_many):
        if field._verbose_name is None:
            yield field, "verbose_name", field.verbose_name
