"""The accounts app."""

from django.apps import AppConfig
from django.utils.translation import gettext_lazy


class AccountsConfig(AppConfig):
    """People and their clearances."""

    name = "accounts"
    verbose_name = gettext_lazy("People and clearance")

    def ready(self) -> None:
        """Connect the signals that end sessions with their account, and forget the browser of a sign-out."""
        from accounts import push, sessions  # noqa: F401, PLC0415 - after the models
