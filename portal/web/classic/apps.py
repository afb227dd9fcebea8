"""The app of the console without scripts."""

from django.apps import AppConfig
from django.utils.translation import gettext_lazy


class ClassicConfig(AppConfig):
    """The console without scripts."""

    name = "portal.web.classic"
    label = "classic"
    verbose_name = gettext_lazy("Console without scripts")
