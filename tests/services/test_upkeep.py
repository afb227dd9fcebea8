"""One command of staff: its grant lasts as long as the command, and nobody loses a place."""

from datetime import timedelta

import pytest

from queueing import services as queue
from queueing.errors import RobotUnavailable
from queueing.estimates import place_and_wait
from queueing.models import PlaceEnd, Ticket, TicketState
from queueing.offers import why_not_ready
from robots import services
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import BadRequest, NotPermitted, Stopped
from robots.models import Command, Grant, Lease, Robot
from robots.states import COMMAND_NEXT, CommandState, Cycle, GrantEnd, GrantKind
from workers.commands import rows

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]
ENDS = sorted(COMMAND_NEXT[CommandState.ACCEPTED] - {CommandState.SENT})


@pytest.fixture
def running(robot, people, owned):
    """A command of kim's that the owner has claimed."""
    command = services.staff_command(robot, people["kim"], "soft_reset")
    assert rows.claim(command, owned.epoch, SYSTEM.now())
    return command


def ready(robot):
    robot.refresh_from_db()
    return why_not_ready(robot, SYSTEM.now())


def in_order(robot):
    """Do what the owner does after the command."""
    assert Robot.objects.filter(pk=robot.pk, cycle=Cycle.HANDOVER).update(cycle=Cycle.READY)
    robot.refresh_from_db()


@pytest.mark.parametrize("end", ENDS)
def test_the_grant_ends_with_its_command_however_it_ends(robot, people, running, end):
    assert "staff" in ready(robot).lower()
    rows.finish(running, end, SYSTEM.now(), "as it happens")
    assert services.open_grant(robot) is None
    assert Grant.objects.get().end_reason == f"soft_reset: {end}"
    in_order(robot)
    assert ready(robot) == ""


def test_an_account_that_is_deleted_leaves_no_open_grant(robot, people, running):
    people["kim"].delete()
    grant = Grant.objects.get()
    assert (grant.holder, grant.end_code, grant.end_reason) == (None, GrantEnd.UNFIT, PlaceEnd.DELETED)
    in_order(robot)  # it may have moved
    assert ready(robot) == ""


def test_a_maintenance_turn_ends_with_its_account(robot, people, owned):
    services.lock_out(robot, people["kim"], "A leaf.")
    services.start_maintenance(robot, people["kim"])
    people["kim"].delete()
    assert services.open_grant(robot) is None
    robot.refresh_from_db()
    assert robot.cycle == Cycle.LOCKED_OUT


def test_a_command_that_nobody_began_ends_it_too(robot, people, owned):
    services.staff_command(robot, people["kim"], "soft_reset")
    assert rows.tidy(robot, owned.epoch, SYSTEM.now() + timedelta(minutes=1), "motion") == 1
    assert services.open_grant(robot) is None


def test_an_owner_that_died_ends_it_when_the_next_one_comes(robot, people, running):
    assert rows.abandon(robot, SYSTEM.now())
    assert services.open_grant(robot) is None


def test_with_no_owner_at_all_the_tick_ends_it_in_time(robot, people, running):
    grant = Grant.objects.get()
    queue.tick(grant.until - timedelta(seconds=1))
    assert services.open_grant(robot) == grant
    queue.tick(grant.until)
    assert services.open_grant(robot) is None


def test_a_stop_before_it_begins_ends_it(robot, people, owned):
    services.staff_command(robot, people["kim"], "soft_reset")
    services.stop(robot, people["kim"])
    assert Command.objects.get().state == "cancelled"
    assert services.open_grant(robot) is None


@pytest.mark.parametrize(("stopped", "kind", "error"), [(True, "soft_reset", Stopped), (False, "fly", BadRequest)])
def test_a_command_that_is_refused_opens_no_grant(robot, people, owned, stopped, kind, error):
    Robot.objects.update(stop_latched=stopped)
    with pytest.raises(error):
        services.staff_command(robot, people["kim"], kind)
    assert not Grant.objects.exists()


def test_it_is_one_command_and_no_turn(robot, people, running):
    with pytest.raises(NotPermitted, match="wait until it has ended"):
        services.issue(robot.slug, people["kim"], "noop", {}, 2)
    with pytest.raises(NotPermitted, match="wait until it has ended"):
        services.staff_command(robot, people["kim"], "still")


def test_a_maintenance_turn_outlives_its_commands(robot, people, owned):
    Robot.objects.update(cycle=Cycle.LOCKED_OUT)
    grant = services.start_maintenance(robot, people["kim"])
    command = services.staff_command(robot, people["kim"], "still")
    rows.claim(command, owned.epoch, SYSTEM.now())
    rows.finish(command, CommandState.COMPLETED, SYSTEM.now())
    assert (services.open_grant(robot), grant.kind) == (grant, GrantKind.STAFF)


@pytest.mark.asvs("2.3.3")
def test_from_the_click_of_staff_to_the_next_turn_no_place_is_lost(robot, people, owned):
    ada, bob = people["ada"], people["bob"]
    now = SYSTEM.now()
    first, second = queue.join(robot, ada, now), queue.join(robot, bob, now)
    queue.tick(now)
    command = services.staff_command(robot, people["kim"], "still")  # in the very moment of the offer
    with pytest.raises(RobotUnavailable, match="[Ss]taff.*keep your place"):
        queue.accept(robot, ada, now)
    first.refresh_from_db()
    assert first.state == TicketState.WAITING
    assert [place_and_wait(robot, ticket, now)[0] for ticket in (first, second)] == [0, 1]
    for s in range(1, 90):  # far longer than any offer
        queue.tick(now + timedelta(seconds=s))
        assert not Ticket.objects.filter(state=TicketState.OFFERED).exists()
        Lease.objects.update(expires_at=now + timedelta(days=1))
    rows.claim(command, owned.epoch, now)
    rows.finish(command, CommandState.COMPLETED, SYSTEM.now())
    later = now + timedelta(seconds=90)
    queue.note_presence(robot, ada, later)
    queue.tick(later)
    assert queue.accept(robot, ada, later).user == ada


def test_an_offer_that_lapses_under_a_command_of_staff_is_taken_back_not_lost(robot, people, owned):
    now = SYSTEM.now()
    ticket = queue.join(robot, people["ada"], now)
    queue.tick(now)
    services.staff_command(robot, people["kim"], "still")
    queue.tick(now + timedelta(seconds=60))
    ticket.refresh_from_db()
    assert ticket.state == TicketState.WAITING


def test_who_is_refused_because_of_another_turn_of_theirs_is_told_so(robot, people, owned):
    from robots.models import Robot as Robots

    other = Robots.objects.create(
        slug="second", name="Second", driver="mercury", address="sim:mercury", enabled=True, cycle=Cycle.READY,
        clearance_required=False,
    )  # fmt: skip
    Lease.objects.create(robot=other, epoch=1, expires_at=SYSTEM.now() + timedelta(days=1))
    now = SYSTEM.now()
    for one in (robot, other):
        queue.join(one, people["ada"], now)
    queue.tick(now)
    queue.accept(robot, people["ada"], now)
    with pytest.raises(RobotUnavailable, match="another robot"):
        queue.accept(other, people["ada"], now)
