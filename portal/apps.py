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
        """Connect the signals of the security log, and those that wake the check of open sockets.

        The movie of the day is not cleaned away.
        """
        from portal.live import changes  # noqa: PLC0415 - models are there only now
        from portal.web.recordings import day  # noqa: PLC0415
        from robots.recordings import cleaning  # noqa: PLC0415

        cleaning.needed.append(day.movies_to_keep)
        checks.register(mail_leaves)
        security.listen()
        changes.listen()
