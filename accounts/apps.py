"""The accounts app."""

from django.apps import AppConfig


class AccountsConfig(AppConfig):
    """People and their clearances."""

    name = "accounts"
    verbose_name = "People and clearance"
