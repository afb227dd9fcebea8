"""Gives names to the table cells that Django's inline rows leave without one."""

from django import template
from django.utils.safestring import SafeString, mark_safe
from django.utils.translation import gettext

register = template.Library()
EMPTY, NAMED = '<th class="original"></th>', '<th class="original"><span class="visually-hidden">{}</span></th>'
LAST, GONE = "<th></th>", "<td></td>"  # the column of the delete box, if rows cannot be deleted


@register.filter
def named(table: SafeString) -> SafeString:
    """Return the table with a heading for its first column, and without an empty heading."""
    named_first = table.replace(EMPTY, NAMED.format(gettext("Row")))
    return mark_safe(named_first.replace(LAST, GONE))  # noqa: S308 - Django's own table, constants for constants
