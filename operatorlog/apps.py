"""The operator's log app."""

from django.apps import AppConfig
from django.utils.translation import gettext_lazy


class OperatorlogConfig(AppConfig):
    """The operator's log and the survey."""

    name = "operatorlog"
    verbose_name = gettext_lazy("Operator's log and survey")
