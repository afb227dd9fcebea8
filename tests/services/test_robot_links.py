"""The page of a robot in the admin leads to each list that can be filtered to it."""

import re
from html import unescape

import pytest
from django.contrib import admin
from django.contrib.admin.utils import get_fields_from_path
from django.urls import reverse

from robots.models import Robot
from tests.services.browsers import signed_in

pytestmark = [pytest.mark.service, pytest.mark.django_db]


def shown(user, address):
    return signed_in(user).get(address).content.decode()


def linked(text):
    """Return the addresses to which a robot's page of the admin leads."""
    about = re.search(r'aria-label="More about this robot">(.*?)</nav>', text, re.DOTALL)[1]
    return [unescape(address) for address in re.findall(r'href="([^"]+)"', about)]


def lists_with_robots():
    """Yield each list of the admin that can be filtered by robot: its address, and the path from a row to the robot."""
    for model, page in admin.site._registry.items():
        for one in page.list_filter:
            path = one[0] if isinstance(one, tuple) else one
            if isinstance(path, str) and get_fields_from_path(model, path)[-1].related_model is Robot:
                yield model, path


def test_a_robots_page_leads_to_each_list_that_has_a_filter_by_robot(used, robot):
    page = f"/admin/robots/robot/{robot.pk}/change/"
    addresses = linked(shown(used["root"], page))
    found = {model: path for model, path in lists_with_robots()}
    labels = {model._meta.label for model in found}
    assert {"queueing.Queue", "queueing.Ticket", "operatorlog.Round", "operatorlog.Find", "operatorlog.Entry",
            "queueing.LostConnection", "alerts.Alert", "robots.Incident", "robots.Recording"} <= labels  # fmt: skip
    client = signed_in(used["root"])
    for model, path in found.items():
        name = reverse(f"admin:{model._meta.app_label}_{model._meta.model_name}_changelist")
        (address,) = [address for address in addresses if address.startswith(f"{name}?")]
        listed = client.get(address).context["cl"].queryset
        assert set(listed) == set(model.objects.filter(**{path: robot})), model
    for address in addresses:
        assert client.get(address).status_code == 200, address
    assert not any("/admin/queueing/turn/" in address for address in linked(shown(used["kim"], page)))
