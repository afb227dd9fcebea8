"""The link in a page's head by which other sites find its frame (`/oembed/`)."""

from django import template
from django.conf import settings
from django.urls import reverse
from django.utils.html import format_html
from django.utils.http import urlencode
from django.utils.safestring import SafeString

register = template.Library()


@register.simple_tag
def oembed_link(path: str, second: int = 0) -> SafeString:
    """Return the element for the page at a path of ours; `second`: of the recording that it shows."""
    link = f"{settings.SITE_ADDRESS}{path}" + (f"?t={second}" if second else "")
    query = urlencode({"url": link, "format": "json"})
    address = f"{settings.SITE_ADDRESS}{reverse('oembed')}?{query}"
    return format_html('<link rel="alternate" type="application/json+oembed" href="{}">', address)
