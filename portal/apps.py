"""The portal app: templates, static files, commands and checks."""

from typing import Any

from django.apps import AppConfig
from django.conf import settings
from django.core import checks
from django.utils.translation import gettext_lazy

from portal.logs import security

UNSENT = ("console", "locmem", "dummy")  # backends that send no mail


class PortalConfig(AppConfig):
    """Pages, sockets and commands."""

    name = "portal"
    verbose_name = gettext_lazy("Portal")

    def ready(self) -> None:
        """Connect signals, exempt the movie of the day from cleaning, and translate the names of models."""
        from portal.live import changes  # noqa: PLC0415 - models are there only now
        from portal.web.recordings import day  # noqa: PLC0415
        from portal.web.translation import names  # noqa: PLC0415
        from robots.recordings import cleaning  # noqa: PLC0415

        names.translate_names()
        cleaning.needed.append(day.movies_to_keep)
        checks.register(mail_leaves)
        checks.register(webhook_is_whole)
        security.listen()
        changes.listen()


def mail_leaves(**_: Any) -> list[checks.CheckMessage]:
    """Refuse a public portal that sends no mails.

    People could not confirm addresses, and links would be written to a log.
    """
    kind = settings.EMAIL_BACKEND.rsplit(".", 2)[-2]
    if not settings.PUBLIC or kind not in UNSENT:
        return []
    text = f"A public portal has to send mails; the {kind} backend sends none."
    hint = "Set EMAIL_URL, for example smtp+tls://user:password@host:587."
    return [checks.Error(text, hint=hint, id="portal.E001")]


def webhook_is_whole(**_: Any) -> list[checks.CheckMessage]:
    """Refuse a webhook of alerts that is not HTTPS, or has no secret by which messages are signed."""
    from portal.web.alerts import webhook  # noqa: PLC0415 - models are there only now

    if not settings.ALERTS["WEBHOOK"]:
        return []
    try:
        webhook.check(settings.ALERTS["WEBHOOK"], settings.ALERTS["SECRET"])
    except ValueError as error:
        return [checks.Error(str(error), id="portal.E002")]
    return []
