"""The robots app."""

from django.apps import AppConfig
from django.utils.translation import gettext_lazy


class RobotsConfig(AppConfig):
    """Catalogue, grants, commands, frames."""

    name = "robots"
    verbose_name = gettext_lazy("Robots")
