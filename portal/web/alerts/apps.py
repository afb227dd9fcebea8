"""The app of alerts."""

from django.apps import AppConfig
from django.utils.translation import gettext_lazy


class AlertsConfig(AppConfig):
    """Tells staff that a robot needs them, and that it is over."""

    name = "portal.web.alerts"
    label = "alerts"
    verbose_name = gettext_lazy("Alerts")
