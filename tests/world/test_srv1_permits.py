"""The hall rover out of reach: on patrol it drives on by its permit, and rests by its end, by the simulator's journal."""

import json
import random
from datetime import timedelta
from math import dist, inf

import pytest

from robots import bus, services
from robots.grants import AnotherGrant, end_grant, start_grant
from robots.kit.contract.streams import unpack
from robots.kit.drivers.srv1.hall import hall
from robots.kit.drivers.srv1.spec import Mode
from robots.models import Grant, Robot
from robots.states import GrantEnd, GrantKind
from tests.world.seeds import hunts

pytestmark = pytest.mark.parametrize("which", ["srv1"], indirect=True)
PERMIT_S = 20.0
FREE = hall().nodes[1].at
BRAKING_S = 0.5  # from the greatest speed, with the moment in which the end of a permit is seen


def patrolling(portal, seconds=9 * 3600.0):
    """Let it patrol for a while under a grant, from where its way is free; return the command."""
    portal.grant()
    assert portal.final(portal.issue("go", x=FREE[0], y=FREE[1]), 120).state == "completed"
    until = portal.world.now() + timedelta(seconds=seconds)
    Grant.objects.filter(pk=services.open_grant(portal.robot).pk).update(until=until)
    command = portal.issue("patrol")
    portal.until(lambda: portal.owner.owned.driver.latest().mode == Mode.PATROL, 60, "its patrol")
    portal.world.sleep(1 + 3 * random.Random(portal.world.seed).random())
    return command


def notes(portal, event):
    return [record for record in portal.rig.journal() if record["event"] == event]


def permitted_until(portal):
    """Return when the newest permit ends, by the simulator's journal."""
    last = notes(portal, "permit")[-1]
    return last["t"] + last["seconds"]


def rests_by(portal, latest, end="permit"):
    """Fail unless it rests by then, and stays at rest."""
    portal.world.sleep(latest - portal.world.monotonic())
    assert not portal.rig.moving, "it rests by then"
    rest = notes(portal, "rest")[-1]
    assert rest["t"] <= latest
    assert rest["end"] in (end, "done"), "done: it stood between driving and turning"
    nothing_begins(portal, 5.0)
    return rest["t"]


def stopped_out_of_reach(portal):
    """Press Stop; return by when the rover rests, as the portal says (s, monotonic)."""

    def told():
        shown = services.stop_shown(portal.row, portal.world.now())
        return shown and shown.rests_by and shown

    bus.send_stop(portal.slug)
    shown = portal.until(told, 30, "the time by which it rests")
    return portal.world.monotonic() + (shown.rests_by - portal.world.now()).total_seconds()


def nothing_begins(portal, seconds, why="something moved by itself"):
    """Fail if a motion begins within so many seconds."""
    begun = portal.rig.count("motion")
    portal.world.sleep(seconds)
    assert portal.rig.count("motion") == begun, why


def told_unseen(portal):
    """Return what the rover did while nobody heard it, by its stream."""
    packets = portal.owner.streams._out[0].packets
    return json.loads(unpack(packets[-1]).data) if packets else None


def set_permit(portal, seconds):
    """Have staff set how long it may drive by itself."""
    portal.ready()
    before = portal.owner.owned.driver
    Robot.objects.filter(pk=portal.robot.pk).update(settings={"permit_s": seconds})
    portal.until(lambda: portal.owner.owned.driver is not before, 10, "the setting")
    portal.ready_again()


@hunts(2, 20, 200)
def test_on_patrol_it_drives_on_inside_its_permit_and_rests_by_its_end(portal):
    command = patrolling(portal)
    at = portal.world.monotonic()
    portal.rig.pull()
    portal.world.sleep(8.0)
    assert portal.rig.moving, "it drives on"
    until = permitted_until(portal)
    assert at + PERMIT_S * 0.85 <= until <= at + PERMIT_S
    rest = rests_by(portal, until + BRAKING_S)
    assert notes(portal, "permit_end")[-1]["why"] == "expired"
    ended = portal.final(command)
    assert ended.state == "failed"
    assert (portal.world.now() - ended.ended_at).total_seconds() <= portal.world.monotonic() - rest
    portal.rig.plug()
    portal.ready_again()
    told = told_unseen(portal)
    (way,) = told["ways"]
    assert told["events"][0][1] == "alone"
    assert told["events"][-1][1] == "rest"
    x, y, _ = portal.rig.sim.world.plant.pose
    assert dist(way[-1], (x, y)) < 0.4, "where it stands now"
    assert portal.final(portal.issue("turn", angle=0.5)).state == "completed"


@hunts(2, 10, 100)
def test_a_patrol_goes_on_when_its_line_is_back_in_time(portal):
    command = patrolling(portal)
    dice = random.Random(portal.world.seed)
    for _ in range(2):
        seconds = 1 + dice.random() * 10
        if dice.random() < 0.5:
            portal.rig.stall(seconds)
            portal.world.sleep(seconds)
        else:
            portal.rig.pull()
            portal.world.sleep(seconds)
            portal.rig.plug()
        portal.world.sleep(3 + dice.random() * 3)
    assert portal.final(command).state == "completed", command.reason
    assert portal.rig.count("motion") == len(notes(portal, "rest"))
    assert notes(portal, "rest")[-1]["end"] == "held"
    assert told_unseen(portal)["ways"]


@hunts(1, 10, 100)
def test_without_a_permit_it_rests_at_once(portal):
    set_permit(portal, 0)
    command = patrolling(portal)
    at = portal.world.monotonic()
    portal.rig.pull()
    rests_by(portal, at + 0.25 + BRAKING_S, "silence")
    assert notes(portal, "permit") == []
    assert portal.final(command).state == "failed"


@hunts(2, 20, 200)
def test_it_rests_before_its_grant_ends(portal):
    seconds = 9.0 + 10.0 * random.Random(portal.world.seed).random()
    command = patrolling(portal, seconds)
    until = portal.world.monotonic() + (services.open_grant(portal.robot).until - portal.world.now()).total_seconds()
    portal.rig.pull()
    assert permitted_until(portal) < until
    assert rests_by(portal, until) < until
    assert portal.final(command).state == "failed"


@hunts(1, 10, 100)
def test_a_hold_ends_its_permit(portal):
    command = patrolling(portal)
    portal.stop()
    portal.rig.pull()
    nothing_begins(portal, PERMIT_S + 5.0)
    assert not portal.rig.moving
    assert portal.final(command).state == "cancelled"


@hunts(2, 20, 200)
def test_a_kill_of_its_owner_on_patrol(portal):
    """The next owner stops it where it can; out of reach it rests by the end of its permit."""
    command = patrolling(portal)
    away = portal.world.seed % 2 == 0
    if away:
        portal.rig.pull()
        portal.world.sleep(random.Random(portal.world.seed).random())
    portal.supervisor.worker.kill()
    if away:
        portal.until(lambda: portal.owner, 30, "another owner")
        assert portal.rig.moving
        rests_by(portal, permitted_until(portal) + BRAKING_S)
        portal.rig.plug()
    else:
        portal.at_rest(30)
        assert notes(portal, "rest")[-1]["end"] in ("replaced", "held")
    assert portal.final(command).state == "unknown"
    nothing_begins(portal, 8.0)


@hunts(3, 20, 200)
def test_a_stop_out_of_reach_says_by_when_it_rests(portal):
    """A stop is not confirmed; it says by when the rover rests, and then it does."""
    command = patrolling(portal)
    dice = random.Random(portal.world.seed)
    portal.rig.pull()
    portal.world.sleep(0.5 + dice.random() * 8)
    by = stopped_out_of_reach(portal)
    assert not services.stop_shown(portal.row, portal.world.now()).confirmed
    assert permitted_until(portal) <= by <= permitted_until(portal) + 1.5
    assert portal.rig.moving, "nothing reaches it"
    if dice.random() < 0.5:
        rests_by(portal, by)
        portal.rig.plug()
    else:
        portal.world.sleep(dice.random() * 3)
        portal.rig.plug()
        portal.at_rest(10)
    portal.until(lambda: services.stop_shown(portal.row, portal.world.now()).confirmed, 30, "a confirmed stop")
    begun = portal.rig.count("motion")
    assert portal.final(command).state == "cancelled"
    portal.world.sleep(10.0)
    assert portal.rig.count("motion") == begun, "nothing moves after a confirmed stop"


@hunts(1, 10, 100)
def test_a_new_owner_counts_it_as_moving_until_it_has_asked(portal):
    """An owner that has not asked the rover yet counts it as moving by the permit of the one before."""
    command = patrolling(portal)
    portal.rig.pull()
    portal.supervisor.worker.kill()
    killed = portal.world.monotonic()
    portal.until(lambda: portal.owner, 30, "another owner")
    by = stopped_out_of_reach(portal)
    assert by >= killed + PERMIT_S
    assert portal.row.stop_latched
    command.refresh_from_db()
    assert command.state == "acknowledged", "it counts as moving"
    rests_by(portal, by)
    assert portal.final(command).state == "unknown"
    assert portal.world.monotonic() >= permitted_until(portal)


@hunts(2, 20, 200)
def test_a_held_joystick_that_loses_its_line_rests_within_half_a_second(portal):
    portal.grant()
    portal.controls.moment_s = inf
    command = portal.move()
    portal.in_motion()
    portal.world.sleep(random.Random(portal.world.seed).random())
    at = portal.world.monotonic()
    portal.rig.pull() if portal.world.seed % 2 else portal.rig.stall(20.0)
    rests_by(portal, at + 0.5, "silence")
    assert notes(portal, "permit") == []
    portal.rig.plug()
    portal.final(command)


@hunts(4, 20, 200)
def test_a_grant_that_ends_early_is_followed_until_it_rests(portal):
    """Whoever ends its grant, the rover moves under an open one, which is for coming to rest and for nothing else."""
    command = patrolling(portal)
    dice, away = random.Random(portal.world.seed), portal.world.seed % 2 == 0
    if away:
        portal.rig.pull()
        portal.world.sleep(dice.random() * 8)
    if dice.random() < 0.5:
        end_grant(services.open_grant(portal.robot), GrantEnd.HOLDER, "ended", portal.world.now())
    else:
        services.lock_out(portal.robot, portal.people["kim"], "something lies in the hall")
    while portal.rig.moving:
        assert services.open_grant(portal.robot).kind == GrantKind.REST
        with pytest.raises(AnotherGrant, match="comes to rest"):
            start_grant(portal.robot, GrantKind.JOB, portal.world.now())
        portal.world.sleep(0.05)
    if away:
        assert rests_by(portal, permitted_until(portal) + BRAKING_S)
    portal.until(lambda: services.open_grant(portal.robot) is None, 10, "the end of its grant")
    assert portal.final(command).final
    portal.rig.plug()


@hunts(1, 10, 100)
def test_a_mission_has_a_permit_while_it_patrols(portal):
    portal.grant()
    command = portal.issue("mission", text="go 2.0 1.0\nwait 1\npatrol 30\n")
    portal.until(lambda: notes(portal, "permit"), 60, "its patrol")
    portal.world.sleep(2.0)
    portal.rig.pull()
    rests_by(portal, permitted_until(portal) + BRAKING_S)
    assert portal.final(command).state == "failed"


@hunts(1, 10, 100)
def test_an_owner_that_ends_takes_the_permit_back(portal):
    """An owner that is told to end holds the rover, and opens nothing again."""
    command = patrolling(portal)
    at = portal.world.monotonic()
    portal.supervisor.worker.terminate()
    portal.until(lambda: portal.supervisor.worker.ended, 20, "its end")
    assert portal.world.monotonic() - at < 10
    portal.at_rest(1.0)
    assert notes(portal, "rest")[-1]["end"] == "held"
    portal.until(lambda: portal.owner, 30, "another owner")
    nothing_begins(portal, 5.0)
    assert portal.final(command).state in ("cancelled", "unknown", "failed")


@hunts(2, 10, 100)
def test_an_owner_that_ends_out_of_reach_leaves_the_end_to_the_next(portal):
    """An owner that ends leaves a motion that may go on: the next owner counts it as moving until it has asked."""
    command = patrolling(portal)
    portal.rig.pull()
    portal.world.sleep(random.Random(portal.world.seed).random())
    portal.supervisor.worker.terminate()
    portal.until(lambda: portal.supervisor.worker.ended, 20, "its end")
    while portal.rig.moving:
        command.refresh_from_db()
        assert command.state == "acknowledged", "it moves"
        assert services.open_grant(portal.robot) is not None
        portal.world.sleep(0.1)
    assert portal.world.monotonic() <= permitted_until(portal) + BRAKING_S
    portal.rig.plug()
    assert portal.final(command, 40).state == "unknown"
