"""The app of Atom feeds."""

from django.apps import AppConfig
from django.utils.translation import gettext_lazy


class FeedsConfig(AppConfig):
    """Atom feeds of the operator's log, and of the times in which robots were out of service."""

    name = "portal.web.feeds"
    label = "feeds"
    verbose_name = gettext_lazy("Atom feeds")
