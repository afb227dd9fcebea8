"""The operator's log app."""

from django.apps import AppConfig


class OperatorlogConfig(AppConfig):
    """What people wrote."""

    name = "operatorlog"
    verbose_name = "Operator's log and survey"
