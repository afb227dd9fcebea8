"""Prepared statements find and change the same rows as the query from which they were compiled."""

import threading
from datetime import timedelta

import pytest
from django.db import DatabaseError, connection, transaction
from django.db.models import BigAutoField, BigIntegerField, CharField, DateTimeField, JSONField

from robots.kit.clock import SYSTEM
from robots.models import Lease, Robot
from robots.prepared import Prepared, PreparedUpdate, Slot
from tests.waiting import CEILING_S

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]
SLUG, EPOCH, NOW = Slot("slug", CharField()), Slot("epoch", BigIntegerField()), Slot("now", DateTimeField())
LEASES = Prepared(
    lambda: Lease.objects.select_related("robot").filter(robot__slug=SLUG, epoch=EPOCH, expires_at__gt=NOW)
)
KEEP = PreparedUpdate(
    lambda: Lease.objects.filter(robot=Slot("robot", BigAutoField()), epoch=EPOCH),
    expires_at=NOW, state=Slot("state", JSONField()),
)  # fmt: skip

LOCKED = Prepared(lambda: Robot.objects.select_for_update().filter(pk=Slot("robot", BigAutoField())))


@pytest.fixture
def lease(robot):
    Lease.objects.filter(robot=robot).delete()
    return Lease.objects.create(robot=robot, epoch=3, expires_at=SYSTEM.now() + timedelta(seconds=60), state={"a": 1})


def test_it_finds_what_its_query_finds_with_other_values_at_each_call(lease, robot, django_assert_num_queries):
    now, late = SYSTEM.now(), SYSTEM.now() + timedelta(seconds=61)
    LEASES(slug="", epoch=0, now=now)
    with django_assert_num_queries(4):
        (found,) = LEASES(slug="mercury", epoch=3, now=now)
        assert (found.pk, found.state, found.expires_at, found.robot) == (lease.pk, {"a": 1}, lease.expires_at, robot)
        assert found.robot.settings == robot.settings
        assert LEASES(slug="mercury", epoch=4, now=now) == []
        assert LEASES(slug="mercury' or '1'='1", epoch=3, now=now) == []
        assert LEASES(slug="mercury", epoch=3, now=late) == []


def test_an_update_changes_only_its_rows_and_says_how_many(lease, robot):
    now = SYSTEM.now()
    assert KEEP(robot=robot.pk, epoch=2, now=now, state={}) == 0
    assert KEEP(robot=robot.pk, epoch=3, now=now, state={"b": [1.5, None]}) == 1
    lease.refresh_from_db()
    assert (lease.expires_at, lease.state) == (now, {"b": [1.5, None]})


def test_threads_use_connections_of_their_own(lease):
    found = []

    def look():
        found.extend(LEASES(slug="mercury", epoch=3, now=SYSTEM.now()))
        connection.close()

    look()
    thread = threading.Thread(target=look)
    thread.start()
    thread.join(CEILING_S)
    look()
    assert [one.pk for one in found] == [lease.pk] * 3


def test_it_sees_and_is_undone_with_its_transaction(lease, robot):
    with transaction.atomic():
        assert KEEP(robot=robot.pk, epoch=3, now=SYSTEM.now(), state={"c": 1})
        assert LEASES(slug="mercury", epoch=3, now=SYSTEM.now() - timedelta(seconds=5))[0].state == {"c": 1}
        transaction.set_rollback(True)
    lease.refresh_from_db()
    assert lease.state == {"a": 1}


def test_a_failed_update_spoils_the_transaction_as_djangos_own_does(lease, robot):
    huge = 2**70  # no database stores such an integer
    with pytest.raises((DatabaseError, OverflowError)), transaction.atomic():
        KEEP(robot=robot.pk, epoch=huge, now=SYSTEM.now(), state={})
    assert KEEP(robot=robot.pk, epoch=3, now=SYSTEM.now(), state={}) == 1


@pytest.mark.skipif(not connection.features.has_select_for_update, reason="SQLite locks no rows")
def test_a_lock_outside_of_a_transaction_is_refused_at_each_call(robot):
    with transaction.atomic():
        assert LOCKED(robot=robot.pk) == [robot]
    with pytest.raises(transaction.TransactionManagementError):
        LOCKED(robot=robot.pk)
