"""The queueing app."""

from django.apps import AppConfig
from django.utils.translation import gettext_lazy


class QueueingConfig(AppConfig):
    """Queues, turns and jobs."""

    name = "queueing"
    verbose_name = gettext_lazy("Queues, turns and jobs")

    def ready(self) -> None:
        """Connect the signal that ends open turns, places and jobs with their account."""
        from queueing import leaving  # noqa: F401, PLC0415 - after the models
