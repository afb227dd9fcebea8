"""Words that Django's admin writes in English whatever the language of the page is, in the reader's language.

Django has no hook for them: an icon of yes or no has Python's word for the value as its text, and a permission the name
that the database has. `tests/services/test_admin_languages.py` fails if Django writes them otherwise one day.
"""

from typing import Any

from django.contrib.admin.templatetags import admin_list
from django.contrib.auth.models import Permission
from django.templatetags.static import static
from django.utils.html import format_html
from django.utils.safestring import SafeString
from django.utils.translation import gettext, gettext_lazy

ICONS = {
    True: ("yes", gettext_lazy("Yes")),
    False: ("no", gettext_lazy("No")),
    None: ("unknown", gettext_lazy("Unknown")),
}
VERBS = {
    "add": gettext_lazy("Can add {row}"), "change": gettext_lazy("Can change {row}"),
    "delete": gettext_lazy("Can delete {row}"), "view": gettext_lazy("Can view {row}"),
}  # fmt: skip


def boolean_icon(value: bool | None) -> SafeString:
    """Return the icon of a value."""
    name, words = ICONS[value]
    return format_html('<img src="{}" alt="{}">', static(f"admin/img/icon-{name}.svg"), words)


def permission_words(permission: Any) -> str:
    """Return a permission with the app and the model to which it belongs."""
    kind = permission.content_type
    verb, _, model = permission.codename.partition("_")
    rows = kind.model_class()
    if verb in VERBS and model == kind.model and rows is not None:
        return f"{kind} | {VERBS[verb].format(row=rows._meta.verbose_name)}"
    return f"{kind} | {gettext(permission.name)}"


def install() -> None:
    """Have the admin write them."""
    admin_list._boolean_icon = boolean_icon  # type: ignore[attr-defined] # not in the stubs
    Permission.add_to_class("__str__", permission_words)  # type: ignore[attr-defined] # not in the stubs
