"""Claiming, advancing and ending command rows."""

from datetime import timedelta

import pytest
from django.db import connection, transaction
from hypothesis import given
from hypothesis import strategies as st

from robots import services
from robots.kit.clock import SYSTEM
from robots.models import Command
from robots.states import COMMAND_FINAL, COMMAND_NEXT, CommandState, GrantKind
from workers.commands import rows

pytestmark = [pytest.mark.service, pytest.mark.django_db]
NOW = SYSTEM.now()


@pytest.fixture
def command(robot, people, owned):
    services.start_grant(robot, GrantKind.TURN, NOW, people["ada"])
    return services.issue(robot.slug, people["ada"], "up", {}, 1, NOW).command


def test_a_command_is_claimed_once_however_often_it_is_delivered(command):
    claims = [rows.claim(Command.objects.get(pk=command.pk), 5, NOW) for _ in range(5)]
    assert claims == [True, False, False, False, False]


def test_another_epoch_claims_nothing(command):
    assert not rows.claim(command, 4, NOW)
    assert not rows.claim(command, 6, NOW)


def test_a_late_command_is_not_claimed_and_expires(command, robot):
    late = NOW + timedelta(seconds=services.START_S + 0.1)
    assert not rows.claim(command, 5, late)
    assert rows.tidy(robot, 5, late, "motion") == 1
    command.refresh_from_db()
    assert (command.state, "too late" in command.reason) == ("expired", True)


def test_a_command_for_an_owner_that_is_gone_expires(command, robot):
    assert rows.tidy(robot, 6, NOW, "motion") == 1
    command.refresh_from_db()
    assert command.state == "expired"


def test_what_was_begun_by_an_owner_that_died_is_unknown(command, robot):
    rows.claim(command, 5, NOW)
    rows.advance(command, CommandState.SENT, NOW)
    assert [c.pk for c in rows.abandon(robot, NOW)] == [command.pk]
    command.refresh_from_db()
    assert command.state == "unknown"
    assert not rows.claim(command, 5, NOW)


def test_a_final_state_is_final(command):
    rows.claim(command, 5, NOW)
    assert rows.finish(command, CommandState.COMPLETED, NOW)
    assert not rows.finish(command, CommandState.FAILED, NOW, "later")
    rows.advance(command, CommandState.SENT, NOW)
    command.refresh_from_db()
    assert command.state == "completed"


@given(st.lists(st.sampled_from(list(CommandState)), max_size=8))
def test_no_path_leads_out_of_a_final_state_nor_back(path):
    state = CommandState.QUEUED
    order = [CommandState.QUEUED, CommandState.ACCEPTED, CommandState.SENT, CommandState.ACKNOWLEDGED]
    for wanted in path:
        if wanted in COMMAND_NEXT[state]:
            assert state not in COMMAND_FINAL
            if wanted in order:
                assert order.index(wanted) > order.index(state)
            state = wanted


@pytest.mark.skipif(connection.vendor != "sqlite", reason="PostgreSQL waits by its own settings")
@pytest.mark.django_db(transaction=True)
def test_a_stage_does_not_wait_for_the_disk_and_everything_after_it_does():
    def waits():
        with connection.cursor() as cursor:
            return cursor.execute("PRAGMA synchronous").fetchone()[0] == 2

    assert waits(), "a row that somebody was told of is on the disk"
    with rows.without_waiting():
        assert not waits()
    assert waits()
    with pytest.raises(RuntimeError), rows.without_waiting():
        raise RuntimeError
    assert waits()
    with transaction.atomic(), rows.without_waiting():
        assert waits(), "inside another transaction nothing changes"
