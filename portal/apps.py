"""The portal app: templates, static files, commands, checks."""

from django.apps import AppConfig


class PortalConfig(AppConfig):
    """Pages, sockets and commands."""

    name = "portal"
    verbose_name = "Portal"
