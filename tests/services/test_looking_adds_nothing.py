"""Visits to pages, even repeated ones, leave no row behind."""

import pytest
from django.apps import apps

from accounts.services import load_bank
from tests.services.test_bad_input import addresses


def rows():
    """How many rows each table has."""
    return {model._meta.label: model.objects.count() for model in apps.get_models()}


@pytest.mark.asvs("2.4.1")
@pytest.mark.django_db
@pytest.mark.parametrize("role", ["anonymous", "signed_in", "cleared", "operator", "superuser"])
def test_looking_at_pages_again_and_again_adds_no_rows(robot, roles, client, role):
    from queueing.models import Turn

    load_bank(robot)
    if role != "anonymous":
        client.force_login(roles[role])
    pages = [a for a in addresses(robot, Turn.objects.get()) if not a.startswith("/favicon")]
    pages += [
        "/classic/mercury/x/",
        "/log/?robot=mercury",
        "/accounts/password/reset/key/x-y/",
        "/accounts/confirm-email/x/",
    ]
    counts = []
    for _ in range(2):
        for page in pages:
            client.get(page, follow=True)
        counts.append(rows())
    assert counts[-1] == counts[0]
