"""How an update changes the rows that a portal has from before."""

from datetime import timedelta

import pytest
from django.db import connection
from django.db.migrations.executor import MigrationExecutor

from queueing.models import Turn
from robots.models import Command, Grant, Robot

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]
NOW_TOLD = {
    ("connection lost", False): "absent", ("connection lost", True): "silent",
    ("idle while others wait", False): "idle", ("idle while others wait", True): "idle",
    ("signed out", False): "signed_out", ("the sign-in ran out", False): "signed_out",
    ("password changed", False): "signed_out", ("account suspended", False): "unfit",
    ("clearance withdrawn", False): "unfit",
}  # fmt: skip


def migrate(*wanted):
    MigrationExecutor(connection).migrate(list(wanted))


@pytest.fixture
def newest():
    """Leaves the database as the newest migration makes it."""
    leaves = MigrationExecutor(connection).loader.graph.leaf_nodes()
    yield leaves
    migrate(*leaves)


def grant(robot, now, **more):
    return Grant.objects.create(robot=robot, kind="turn", opened_at=now, ended_at=now, **more)


def codes():
    found = Turn.objects.values_list("end_reason", "classic", "grant__end_code")
    return {(reason, classic): code for reason, classic, code in found}


def test_each_turn_of_before_is_told_why_it_ended_and_the_way_back_is_open(robot, people, clock, newest):
    before, now = ("queueing", "0013_turns_outlive_accounts"), clock.now()
    migrate(before)
    for reason, classic in NOW_TOLD:
        Turn.objects.create(
            robot=robot, user=people["ada"], classic=classic, end_reason=reason, started_at=now, base_until=now,
            until=now, last_seen=now, ended_at=now, grant=grant(robot, now, end_code="absent", end_reason=reason),
        )  # fmt: skip
    migrate(*newest)
    assert codes() == NOW_TOLD
    migrate(before)
    assert set(codes().values()) == {"absent", "unfit"}, "codes that the version before knows"


def test_a_stop_of_before_gets_the_newest_command_of_then(robot, clock, newest):
    stopped, at = clock.now(), clock.now
    others = [Robot.objects.create(slug=slug, name=slug, address="sim:mercury") for slug in ("other", "never")]
    rows = {}
    for one in (robot, *others):
        under = grant(one, at())
        rows[one.slug] = [
            Command.objects.create(
                robot=one, grant=under, client_seq=seconds, kind="up", epoch=1, deadline=at(),
                created_at=stopped + timedelta(seconds=seconds),
            ).pk
            for seconds in (-20, -10, 10)
        ]  # fmt: skip
    Robot.objects.filter(pk=robot.pk).update(stopped_at=stopped)
    Robot.objects.filter(slug="other").update(stopped_at=stopped - timedelta(seconds=30))
    migrate(("robots", "0023_movie_progress"))
    migrate(*newest)
    found = dict(Robot.objects.values_list("slug", "stopped_after"))
    assert found == {robot.slug: rows[robot.slug][1], "other": 0, "never": None}
