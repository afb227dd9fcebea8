"""The token of a form that must be carried out once."""

import secrets

from django import template
from django.utils.html import format_html
from django.utils.safestring import SafeString

from robots.once import FIELD

register = template.Library()


@register.simple_tag
def once(name: str = FIELD) -> SafeString:
    """Return a hidden field with a new token."""
    return format_html('<input type="hidden" name="{}" value="{}">', name, secrets.token_urlsafe(24))
