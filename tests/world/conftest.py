"""Fixtures of the tests in virtual time."""

import shutil
from contextlib import ExitStack

import pytest
from django.conf import settings
from django.contrib.auth.models import Permission

from tests.world.delays import NONE
from tests.world.portal import Portal

FOLDER = settings.VAR / "world"  # of the simulator, which writes its place while it moves: in memory


@pytest.fixture
def worlds(transactional_db, robot, people):
    """Begin a world with a robot, its owner and its supervisor; the one before is closed."""
    with ExitStack() as opened:

        def begin(seed: int, delays=NONE) -> Portal:
            opened.close()
            wipe_doings()
            shutil.rmtree(FOLDER, ignore_errors=True)
            made = Portal(seed, robot, people, FOLDER, delays)
            opened.callback(made.close)
            if made.wishes.by_staff:
                ada = people["ada"]
                ada.is_staff = True
                ada.save()
                ada.user_permissions.add(Permission.objects.get(codename="change_robot"))
                people["ada"] = type(ada).objects.get(pk=ada.pk)  # which has read no permissions yet
            return made

        yield begin


def wipe_doings() -> None:
    """Remove what a run before has made."""
    from robots.models import Command, Grant, Incident, Lease

    for model in (Command, Grant, Incident, Lease):
        model.objects.all().delete()
