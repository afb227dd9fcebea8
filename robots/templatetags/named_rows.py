"""What Django's table of inline rows leaves without a name."""

from django import template
from django.utils.safestring import SafeString, mark_safe

register = template.Library()
EMPTY, NAMED = '<th class="original"></th>', '<th class="original"><span class="visually-hidden">Row</span></th>'


@register.filter
def named(table: SafeString) -> SafeString:
    """Return the table with a heading over its first column."""
    return mark_safe(table.replace(EMPTY, NAMED))  # noqa: S308 - Django's own table, one constant for another
