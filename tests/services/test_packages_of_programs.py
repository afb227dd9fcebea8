"""The owner's package of a program: a text that it cannot store is refused, and ends nothing but the command."""

import pytest
from django.db import connection

from robots import services
from robots.models import Command
from tests.services.owner import made_owner

pytestmark = pytest.mark.django_db(transaction=True)


@pytest.fixture
def which():
    return "srv1"


@pytest.fixture
def owner(robot, people):
    return made_owner(robot, people)


@pytest.mark.skipif(connection.vendor == "postgresql", reason="PostgreSQL stores no half of a letter")
def test_a_text_that_cannot_be_written_is_refused_and_the_owner_goes_on(owner, people):
    for seq in range(1, 5):
        text = {"text": "photograph"}
        command = services.issue(owner.owned.robot.slug, people["ada"], "mission", text, seq, owner.owned.now()).command
        # as an earlier version may have left it, which checked less
        Command.objects.filter(pk=command.pk).update(args={"text": "# \ud800\nphotograph"})
        command.refresh_from_db()
        owner.motion.run_one(command)
        command.refresh_from_db()
        assert (command.state, command.result["code"]) == ("rejected", "bad_request"), command.reason
