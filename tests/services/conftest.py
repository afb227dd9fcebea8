"""People of eight roles from a stranger to the superuser; and a robot that takes jobs."""

from datetime import timedelta
from math import inf

import pytest
from django.core.cache import caches


@pytest.fixture(autouse=True)
def english():
    """A page leaves its reader's language active, which the next test has not chosen."""
    from django.utils import translation

    with translation.override("en"):
        yield


@pytest.fixture
def one_count(request, monkeypatch):
    """Have attempts counted in memory alone, as without Redis: a busy one that answers late would split the count."""
    if "redis_server" not in request.fixturenames:
        monkeypatch.setattr(caches["default"], "_away_until", inf)


ROLES = ("anonymous", "signed_in", "cleared", "operator", "log_moderator", "viewer", "robot_staff", "superuser")


@pytest.fixture
def roles(robot, people, owned, django_user_model):
    """One person a role. The operator's turn is open; the viewer is staff who may look at everything."""
    from django.contrib.auth.models import AnonymousUser, Permission

    from robots.kit.clock import SYSTEM
    from tests.services.turns import drive

    viewer = django_user_model.objects.create_user("vic", "vic@example.org", "correct horse 42", is_staff=True)
    viewer.user_permissions.set(Permission.objects.filter(codename__startswith="view_"))
    root = django_user_model.objects.create_superuser("root", "root@example.org", "correct horse 42")
    drive(robot, people["bob"], SYSTEM.now())
    cast = (AnonymousUser(), people["eve"], people["ada"], people["bob"], people["mod"], viewer, people["kim"], root)
    return dict(zip(ROLES, cast, strict=True))


@pytest.fixture
def media(settings, tmp_path):
    """An empty folder for pictures, recordings and movies, on a disk with room for them."""
    settings.MEDIA_ROOT = tmp_path / "media"
    settings.MEDIA_ROOT.mkdir()
    settings.RECORDING = settings.RECORDING | {"FREE_MB": 1}
    return settings.MEDIA_ROOT


@pytest.fixture
def grant(robot, people, owned):
    """The open turn of ada, for five minutes of the real time of day."""
    from robots import services
    from robots.kit.clock import SYSTEM
    from robots.states import GrantKind

    now = SYSTEM.now()
    return services.start_grant(robot, GrantKind.TURN, now, people["ada"], now + timedelta(minutes=5))


@pytest.fixture
def shuttle(robot, people, clock, monkeypatch):
    """A shuttle that takes jobs from guests, charged in jobs; nobody drives it, and it does not roam."""
    from queueing.models import QueueRobot
    from robots.models import Lease, Robot
    from tests.packaged import SHUTTLE, installed_from

    with installed_from(SHUTTLE, monkeypatch):
        Robot.objects.filter(pk=robot.pk).update(driver="shuttle", calibration={})
        robot.refresh_from_db()
        Lease.objects.create(robot=robot, epoch=5, expires_at=clock.now() + timedelta(days=9))
        QueueRobot.objects.filter(robot=robot).update(
            offers_turns=False,
            guests_ask=True,
            charged_in="jobs",
            rest_after_min=1,
            watched_at=clock.now() - timedelta(days=1),
        )
        monkeypatch.setattr("robots.bus.may_be_watched", lambda slug: False)
        yield robot


@pytest.fixture
def used(robot, people, django_user_model, settings, tmp_path):
    """A portal in use, with a superuser among its people."""
    from robots.kit.clock import SYSTEM
    from tests.services.in_use import in_use

    settings.MEDIA_ROOT = tmp_path
    people["root"] = django_user_model.objects.create_superuser("root", "root@example.org", "correct horse 42")
    in_use(robot, people, SYSTEM.now())
    return people
