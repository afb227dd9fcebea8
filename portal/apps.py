"""The portal app: templates, static files, commands and checks."""

from django.apps import AppConfig
from django.core import checks

from portal.checks import mail_leaves
from portal.logs import security


class PortalConfig(AppConfig):
    """Pages, sockets and commands."""

    name = "portal"
    verbose_name = "Portal"

    def ready(self) -> None:
        """Connect the signals of the security log, and those that wake the check of open sockets."""
        from portal.live import changes  # noqa: PLC0415 - models are there only now

        checks.register(mail_leaves)
        security.listen()
        changes.listen()
