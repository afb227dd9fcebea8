"""The accounts app."""

from django.apps import AppConfig


class AccountsConfig(AppConfig):
    """People and what they are cleared for."""

    name = "accounts"
    verbose_name = "People and clearance"
