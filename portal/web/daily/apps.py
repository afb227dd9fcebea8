"""The app of the daily figures."""

from django.apps import AppConfig
from django.utils.translation import gettext_lazy


class DailyConfig(AppConfig):
    """Daily figures of the portal and of each robot."""

    name = "portal.web.daily"
    label = "daily"
    verbose_name = gettext_lazy("Daily figures")
