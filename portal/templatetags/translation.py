"""The reader's language and time zone in templates."""

from datetime import date, datetime
from typing import Any

from django import template
from django.conf import settings
from django.urls import reverse
from django.utils.html import format_html
from django.utils.safestring import SafeString
from django.utils.timezone import get_current_timezone_name, localtime
from django.utils.translation import get_language

from portal.web.translation.views import version_of
from robots.dates import date_words
from robots.people import driver_name, shown_name
from robots.sentences import declared, translate

register = template.Library()
register.filter("translate", translate)
register.filter("declared", declared)
register.filter("shown_name", shown_name)


@register.filter
def lower_first(text: str) -> str:
    """Return a text with a small first letter; the others stay, as German nouns need."""
    return f"{text[:1].lower()}{text[1:]}"


@register.filter
def driver(person: Any, viewer: Any) -> str:
    """Return who drives or has driven, as the viewer may read it."""
    return shown_name(driver_name(person, viewer))


@register.simple_tag
def texts() -> str:
    """Return the element that loads the texts of the page's scripts; English needs none."""
    language = get_language() or settings.LANGUAGE_CODE
    if language == settings.LANGUAGE_CODE:
        return SafeString()
    return format_html('<script src="{}"></script>', reverse("texts", args=(language, version_of(language))))


@register.simple_tag
def languages() -> list[tuple[str, str]]:
    """Return the codes of the languages and their own names, which are the same in each language."""
    return list(settings.LANGUAGES)


@register.filter
def day(on: date) -> str:
    """Return a day of the calendar, such as one of UTC, in words."""
    return date_words(on)


@register.filter
def moment(at: datetime | None, kind: str = "minute") -> str:
    """Return the element of a time in the reader's zone. `kind`: `day`, `minute`, `second` or `time` (without its day).

    Until the browser has named its zone it is in UTC and says so; `frontend/src/page/zone.ts` then writes it anew.
    """
    if at is None:
        return ""
    zone = " UTC" if get_current_timezone_name() == "UTC" and kind != "day" else ""
    shown = date_words(localtime(at), kind) + zone
    return format_html('<time datetime="{}" data-moment="{}">{}</time>', at.isoformat(), kind, shown)
