"""The queueing app."""

from django.apps import AppConfig


class QueueingConfig(AppConfig):
    """Queues, turns and jobs."""

    name = "queueing"
    verbose_name = "Queue and turns"
