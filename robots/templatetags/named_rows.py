"""Gives names to the table cells that Django's inline rows leave without one."""

from django import template
from django.utils.safestring import SafeString, mark_safe

register = template.Library()
EMPTY, NAMED = '<th class="original"></th>', '<th class="original"><span class="visually-hidden">Row</span></th>'
LAST, GONE = "<th></th>", "<td></td>"  # the column of the delete box, if rows cannot be deleted


@register.filter
def named(table: SafeString) -> SafeString:
    """Return the table with a heading for its first column, and without an empty heading."""
    return mark_safe(table.replace(EMPTY, NAMED).replace(LAST, GONE))  # noqa: S308 - Django's own table, constants for constants
