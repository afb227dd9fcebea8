"""The app of the console without scripts."""

from django.apps import AppConfig


class ClassicConfig(AppConfig):
    """The console without scripts."""

    name = "portal.web.classic"
    label = "classic"
    verbose_name = "Console without scripts"
