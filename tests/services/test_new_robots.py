"""A new robot whose package has a question file that cannot be read."""

import pytest

from accounts.models import Question
from robots.kit import description
from robots.models import Robot

pytestmark = [pytest.mark.service, pytest.mark.django_db]
SECOND = {
    "name": "Second", "slug": "second", "driver": "mercury", "address": "sim:mercury", "clearance_required": "on",
    "records": "off",
}  # fmt: skip
HALF = """[[question]]
text = "Why?"
choices = ["So", "Or so"]
[[question]]
text = "Why not?"
"""


@pytest.mark.parametrize("broken", [HALF, "no toml"])
def test_it_is_added_and_staff_are_told(robot, client, admin_user, monkeypatch, broken):
    monkeypatch.setattr(description, "text_of", lambda driver, name: broken)
    client.force_login(admin_user)
    page = client.post("/admin/robots/robot/add/", SECOND, follow=True)
    assert "clearance.toml of its package cannot be read" in " ".join(str(m) for m in page.context["messages"])
    assert Robot.objects.filter(slug="second").exists()
    assert not Question.objects.filter(robot__slug="second").exists(), "all of them or none"
