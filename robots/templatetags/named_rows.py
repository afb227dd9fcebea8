"""What Django's table of inline rows leaves without a name."""

from django import template
from django.utils.safestring import SafeString, mark_safe

register = template.Library()
EMPTY, NAMED = '<th class="original"></th>', '<th class="original"><span class="visually-hidden">Row</span></th>'
LAST, GONE = "<th></th>", "<td></td>"  # over the column of a box that deletes, where nothing can be deleted


@register.filter
def named(table: SafeString) -> SafeString:
    """Return the table with a heading over its first column, and no empty one."""
    return mark_safe(table.replace(EMPTY, NAMED).replace(LAST, GONE))  # noqa: S308 - Django's own table, constants for constants
