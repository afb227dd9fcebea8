"""The operator's log app."""

from django.apps import AppConfig


class OperatorlogConfig(AppConfig):
    """The operator's log and the survey."""

    name = "operatorlog"
    verbose_name = "Operator's log and survey"
