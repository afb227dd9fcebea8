"""The app of the daily figures."""

from django.apps import AppConfig


class DailyConfig(AppConfig):
    """Daily figures of the portal and of each robot."""

    name = "portal.web.daily"
    label = "daily"
    verbose_name = "Daily figures"
