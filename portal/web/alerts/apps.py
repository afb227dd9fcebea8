"""The app of alerts."""

from django.apps import AppConfig


class AlertsConfig(AppConfig):
    """Tells staff that a robot needs them, and that it is over."""

    name = "portal.web.alerts"
    label = "alerts"
    verbose_name = "Alerts"
