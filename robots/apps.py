"""The robots app."""

from django.apps import AppConfig


class RobotsConfig(AppConfig):
    """Catalogue, grants, commands, frames."""

    name = "robots"
    verbose_name = "Robots"
