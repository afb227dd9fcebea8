"""The owner's lease in the database."""

import threading
from dataclasses import replace
from datetime import timedelta

import pytest
from django.db import connection

from robots.kit.clock import SYSTEM
from robots.models import Lease
from tests.services.owner import made_owner
from tests.waiting import CEILING_S
from workers.authority.lease import OwnerLease

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]


@pytest.fixture
def lease(robot, tmp_path):
    lease = OwnerLease(robot, tmp_path / "lock")
    assert lease.acquire(lambda: False)
    yield lease
    lease.give_back()


def renew(lease):
    try:
        lease.renew()
    finally:
        connection.close()


def test_a_renewal_under_way_does_not_bring_back_a_lease_that_was_given_back(lease, monkeypatch):
    asked, go_on = threading.Event(), threading.Event()

    def measured():
        asked.set()
        go_on.wait(CEILING_S)

    monkeypatch.setattr(lease, "measure_offset", measured)
    renewal = threading.Thread(target=renew, args=(lease,))
    renewal.start()
    assert asked.wait(CEILING_S)
    lease.give_back()
    go_on.set()
    renewal.join(CEILING_S)
    assert Lease.objects.get().expires_at <= SYSTEM.now() + lease.offset


def test_a_lease_that_somebody_else_has_taken_is_lost(lease):
    before = SYSTEM.now()
    lease.renew()
    assert lease.valid
    assert Lease.objects.get().expires_at > before + timedelta(seconds=1)
    Lease.objects.update(epoch=lease.epoch + 1)
    lease.renew()
    assert not lease.valid


def test_of_two_states_the_newer_one_is_remembered_whichever_is_stored_last(robot, people):
    owner = made_owner(robot, people)
    older = owner.owned.driver.latest()
    newer = replace(older, at=older.at + 1, ready=not older.ready)
    for state, ready in ((newer, newer.ready), (older, newer.ready), (newer, newer.ready)):
        owner.owned.remember(state)
        assert Lease.objects.get().state["ready"] == ready
    owner.lease.give_back()
