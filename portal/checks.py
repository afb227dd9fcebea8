"""Checks for a public portal, run at the start of every command and by `check --deploy`."""

from typing import Any

from django.conf import settings
from django.core.checks import CheckMessage, Error

UNSENT = ("console", "locmem", "dummy")


def mail_leaves(**_: Any) -> list[CheckMessage]:
    """Refuse a public portal that sends no mails.

    People could not confirm addresses, and links would be written to a log.
    """
    kind = settings.EMAIL_BACKEND.rsplit(".", 2)[-2]
    if not settings.PUBLIC or kind not in UNSENT:
        return []
    hint = "Set EMAIL_URL, for example smtp+tls://user:password@host:587."
    return [Error(f"A public portal has to send mails; the {kind} backend sends none.", hint=hint, id="portal.E001")]
