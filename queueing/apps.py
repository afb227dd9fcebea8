"""The queueing app."""

from django.apps import AppConfig


class QueueingConfig(AppConfig):
    """Whose turn it is."""

    name = "queueing"
    verbose_name = "Queue and turns"
