"""The end of a stop, a lock-out, maintenance or a fault starts no motion: a release needs a look at the picture."""

from dataclasses import replace
from datetime import timedelta

import pytest
from django.db.models import F
from django.test import Client

from portal.live.actions import act
from portal.live.messages import Release
from portal.web.classic.pictures import has_classic_console
from queueing.services import resume
from robots import services
from robots.kit.contract.errors import NotPermitted
from robots.models import Grant, Incident, Robot
from robots.services.incidents import incident
from robots.services.status import status_of
from robots.states import Cycle, GrantEnd, GrantKind
from tests.services.lifted import World
from workers.robot import handover

# the rows are alike for all robots: of one, they are asked of each database
WHICH = [pytest.param("mercury", marks=pytest.mark.service), "pa10", "irat"]
pytestmark = [pytest.mark.django_db(transaction=True), pytest.mark.parametrize("which", WHICH, indirect=True)]
AWAY = {"mercury": "up", "pa10": "home", "irat": "explore"}


@pytest.fixture
def world(robot, people, clock, monkeypatch):
    """A robot that somebody has moved; its turn is over, and nothing moves it."""
    made = World(robot, clock, monkeypatch)
    made.people, made.kim = people, people["kim"]
    made.goes_on(4)
    given(made)
    made.driver.moves.clear()
    return made


def nobody_has(world):
    """End the grant of the robot's own behaviour, if there is one."""
    for grant in Grant.objects.filter(ended_at=None):
        services.end_grant(grant, GrantEnd.PREEMPTED, "staff come first", world.clock.now())


def given(world):
    """Have staff give the robot a command, which moves it away from its home; nobody has it afterwards."""
    nobody_has(world)
    held = services.start_grant(world.robot, GrantKind.TURN, world.clock.go(1), world.kim)
    services.issue(world.robot.slug, world.kim, AWAY[world.robot.driver], {}, 1, world.clock.now())
    world.goes_on(2)
    assert world.driver.moves[-1] == AWAY[world.robot.driver]
    services.end_grant(held, GrantEnd.HOLDER, "left", world.clock.go(1))


def signed_in(world):
    """Return a browser of staff, and the scope of its socket."""
    browser = Client()
    browser.force_login(world.kim)
    return browser, {"cookies": {name: one.value for name, one in browser.cookies.items()}}


def do(world, verb, **said):
    """Press a button of the admin."""
    return signed_in(world)[0].post(f"/admin/robots/robot/{world.robot.pk}/do/{verb}/", said, follow=True)


def locked(world):
    services.lock_out(world.robot, world.kim, "hands in the cell")
    world.goes_on(3)


def lift(world):
    locked(world)
    services.lift_lock_out(world.robot, world.kim)


def lift_in_the_admin(world):
    locked(world)
    answer = do(world, "lift")
    assert b"look at the newest picture" in answer.content


def lift_after_maintenance(world):
    locked(world)
    services.start_maintenance(world.robot, world.kim)
    services.release_stop(world.robot, world.kim, checked=True)
    world.goes_on(3)
    services.lift_lock_out(world.robot, world.kim)


def maintenance_runs_out(world):
    locked(world)
    services.start_maintenance(world.robot, world.kim)
    world.clock.go(31 * 60)


def switched(world):
    services.set_enabled(world.robot, world.kim, False)
    world.goes_on(3)
    services.set_enabled(world.robot, world.kim, True)


def switched_under_lock_out(world):
    locked(world)
    services.set_enabled(world.robot, world.kim, False)
    services.lift_lock_out(world.robot, world.kim)
    services.set_enabled(world.robot, world.kim, True)


def stopped(world):
    services.stop(world.robot, world.kim)
    world.goes_on(3)


def restarted(world):
    stopped(world)
    world.begin()


def restarted_in_fault(world):
    stopped(world)
    Robot.objects.update(cycle=Cycle.FAULT, reason="It could not be put in order.")
    world.begin()


def cable(world):
    stopped(world)
    world.driver.pulled = True
    world.owner.connection.lost_while_idle(_gone(world))
    world.goes_on(8)
    assert world.row.cycle == Cycle.FAULT
    world.driver.pulled = False


def _gone(world):
    with pytest.raises(Exception, match="vanished") as error:
        world.driver.connect()
    return error.value


def turn_ends(world):
    grant = services.start_grant(world.robot, GrantKind.TURN, world.clock.now(), world.people["ada"])
    stopped(world)
    services.end_grant(grant, GrantEnd.TIME_UP, "time is up", world.clock.now())
    Robot.objects.update(cycle=Cycle.HANDOVER)


def lease_ran_out(world):
    stopped(world)
    world.clock.go(10)


def resumed(world):
    stopped(world)
    with pytest.raises(NotPermitted, match="Release the stop first"):
        resume(world.robot, world.kim, world.clock.now())


def procedures(world):
    stopped(world)
    for kind in ("calibrate", "reset"):
        do(world, "procedure", kind=kind)


def address(world):
    stopped(world)
    Robot.objects.update(address="tcp:192.0.2.1:2000")


def incident_closed(world):
    stopped(world)
    incident(world.robot, "hardware_fault", "It failed.", world.clock.now())
    services.close_incident(Incident.objects.get(), world.kim)


def released_without_a_look(world):
    stopped(world)
    with pytest.raises(NotPermitted, match="Look at the newest picture"):
        services.release_stop(world.robot, world.kim, checked=False)
    do(world, "release")
    browser, scope = signed_in(world)
    browser.post(f"/classic/{world.robot.slug}/any-token/", {"do": "release"})
    assert "Look at the newest picture" in act(scope, world.robot.slug, Release()).text


VERBS = (
    lift, lift_in_the_admin, lift_after_maintenance, switched, switched_under_lock_out, stopped, restarted,
    restarted_in_fault, cable, turn_ends, lease_ran_out, resumed, procedures, address, incident_closed,
    released_without_a_look, maintenance_runs_out,
)  # fmt: skip


@pytest.mark.parametrize("verb", VERBS, ids=lambda verb: verb.__name__)
def test_a_stop_outlives_it_and_nothing_moves(world, verb):
    verb(world)
    world.goes_on(13, 2.0)
    assert world.driver.moves == []
    row = world.row
    assert row.stop_latched, "a release needs the look at the picture"
    assert world.owner.latch.latched
    assert row.cycle == (Cycle.LOCKED_OUT if verb is maintenance_runs_out else Cycle.READY)
    if row.cycle == Cycle.READY:
        said = ("stopped", "Stopped", "Stopped. Release needs a look at the picture.")
        assert status_of(row, world.clock.now()) == said


def by_the_console(world):
    _, scope = signed_in(world)
    assert act(scope, world.robot.slug, Release(checked=True)).ok


def by_the_admin(world):
    do(world, "release", checked="yes")


def by_the_classic_page(world):
    if not has_classic_console(world.robot):
        pytest.skip("has no classic page")
    signed_in(world)[0].post(f"/classic/{world.robot.slug}/any-token/", {"do": "release", "checked": "yes"})


def while_it_is_put_in_order(world):
    """The stop comes in the middle of the homing, and is released before the handover is tried again."""
    if not world.robot.spec().handover:
        pytest.skip("is not homed")
    nobody_has(world)
    Robot.objects.update(cycle=Cycle.HANDOVER)
    world.driver.on_the_way = lambda: services.stop(world.robot, world.kim) or world.owner.stopping.halt("test")
    world.goes_on(2)
    world.driver.on_the_way = lambda: None
    world.driver.moves.clear()
    services.release_stop(world.robot, world.kim, checked=True)


def while_it_is_off(world):
    services.set_enabled(world.robot, world.kim, False)
    world.goes_on(3)
    services.release_stop(world.robot, world.kim, checked=True)
    services.set_enabled(world.robot, world.kim, True)


def then_restarted(world):
    by_the_admin(world)
    world.goes_on(3)
    world.begin()


def then_the_cable(world):
    by_the_admin(world)
    world.goes_on(3)
    world.driver.pulled = True
    world.owner.connection.lost_while_idle(_gone(world))
    world.goes_on(3)
    world.driver.pulled = False


def then_a_turn_without_a_command(world):
    by_the_admin(world)
    grant = services.start_grant(world.robot, GrantKind.TURN, world.clock.go(1), world.people["ada"])
    services.end_grant(grant, GrantEnd.HOLDER, "left", world.clock.go(1))
    Robot.objects.update(cycle=Cycle.HANDOVER)


def after_the_time_of_day_was_set_back(world):
    Robot.objects.update(stopped_at=F("stopped_at") - timedelta(days=1))  # as the queues' stamps follow the clock
    by_the_admin(world)


RELEASES = (
    by_the_console, by_the_admin, by_the_classic_page, while_it_is_put_in_order, while_it_is_off, then_restarted,
    then_the_cable, then_a_turn_without_a_command, after_the_time_of_day_was_set_back,
)  # fmt: skip


@pytest.mark.parametrize("release", RELEASES, ids=lambda release: release.__name__)
def test_a_release_after_a_look_starts_nothing_until_somebody_gives_a_command(world, release):
    if release is not while_it_is_put_in_order:
        stopped(world)
    release(world)
    world.goes_on(13, 2.0)
    assert world.driver.moves == []
    row = world.row
    assert (row.stop_latched, world.owner.latch.latched, row.cycle) == (False, False, Cycle.READY)
    given(world)
    Robot.objects.update(cycle=Cycle.HANDOVER)
    world.goes_on(3)
    homed = list(world.robot.spec().handover)
    assert world.driver.moves[1 : 1 + len(homed)] == homed, "from now on it is homed again"


@pytest.mark.parametrize(
    ("release", "why"), [(None, handover.STOPPED), (by_the_admin, handover.RELEASED)], ids=["stopped", "released"]
)
def test_a_robot_that_moves_by_itself_is_not_offered_and_the_reason_is_true(world, monkeypatch, release, why):
    stopped(world)
    if release is not None:
        release(world)
    world.goes_on(3)
    nobody_has(world)
    monkeypatch.setattr(world.driver, "state", lambda: replace(world.driver.latest(), moving=True))
    Robot.objects.update(cycle=Cycle.HANDOVER)
    world.goes_on(3)
    assert why in world.row.reason
