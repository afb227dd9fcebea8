"""What a portal on the open web must not have: asked at the start of every command, and by `check --deploy`."""

from typing import Any

from django.conf import settings
from django.core.checks import CheckMessage, Error

UNSENT = ("console", "locmem", "dummy")


def mail_leaves(**_: Any) -> list[CheckMessage]:
    """Refuse a public portal whose mails go nowhere: nobody could confirm an address, and links would be in a log."""
    kind = settings.EMAIL_BACKEND.rsplit(".", 2)[-2]
    if not settings.PUBLIC or kind not in UNSENT:
        return []
    hint = "Set EMAIL_URL, for example smtp+tls://user:password@host:587."
    return [Error(f"A public portal has to send mails; the {kind} backend sends none.", hint=hint, id="portal.E001")]
