"""Browsers of people."""

from django.test import Client


def signed_in(user=None, **options):
    """Return a browser in which the person is signed in; a stranger's browser without a person."""
    client = Client(**options)
    if user is not None and user.is_authenticated:
        client.force_login(user)
    return client
