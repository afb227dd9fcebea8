"""The hall rover in virtual time: its owner, driver, firmware and hall; what it never does, and what survives what."""

import random
import shutil
from hashlib import sha256
from itertools import pairwise
from math import dist, inf, pi

import pytest
from django.conf import settings

from robots.kit.drivers.srv1.hall import hall
from robots.kit.drivers.srv1.missions import LOOK_S
from robots.kit.drivers.srv1.motions import IN_THE_WAY, TOO_NEAR
from robots.models import Finding, Frame
from tests.world.motions import Motions
from tests.world.seeds import hunt, seeds
from tests.world.steps import held, moved_by, nothing_moves, rested, stop_each
from workers.commands.packages import NOT_STORED

pytestmark = pytest.mark.parametrize("which", ["srv1"], indirect=True)
REST_S = 0.25 + 0.3  # its watchdog, and the braking from its greatest speed
PLACE = hall().nodes[1].at
sent = moved_by("go", x=PLACE[0], y=PLACE[1])
patrolling = moved_by("patrol")


@seeds(1, 20, 200)
def test_a_stop_overtakes_each_of_its_motions(worlds, seed):
    hunt(worlds, seed, lambda portal: stop_each(portal, (held, sent, patrolling), REST_S))


def goes(portal):
    """It was carried elsewhere while it was off: it looks around, finds out where it is, and goes."""
    portal.grant()
    dice, plant = random.Random(portal.world.seed), portal.rig.sim.world.plant
    node = dice.choice(hall().nodes)
    plant.put(*node.at, dice.uniform(-pi, pi))
    portal.rig.power_cycle()
    portal.until(lambda: portal.rig.count("power_on") > 1, 30, "another start")
    portal.until(lambda: portal.rig.count("connected") > 1, 60, "another connection")
    portal.world.sleep(5)
    assert portal.owner.owned.driver.latest().pose == (), "nobody says that it is at home"
    command = portal.final(sent(portal), 200)
    assert command.state == "completed", command.reason
    x, y, _ = plant.pose
    assert dist((x, y), PLACE) < 0.25, "it is where it was sent"
    shown = portal.owner.owned.driver.state()
    assert dist(shown.pose[:2], (x, y)) <= max(0.1, 1.5 * shown.values["spread"]), "it is as sure as it says"
    assert portal.rig.sim.world.plant.contacts == (), "it touched nothing"


@seeds(1, 10, 100)
def test_it_goes_where_it_is_sent(worlds, seed):
    hunt(worlds, seed, goes)


def blocked(portal):
    """A showcase was pushed into its way: it waits before it, gives up, and touches nothing."""
    portal.grant()
    portal.rig.sim.world.plant.move("Ammonites", 0.5, -0.95)
    command = portal.final(portal.issue("go", x=6.0, y=2.3), 200)
    assert (command.state, command.reason) == ("failed", IN_THE_WAY)
    assert portal.rig.sim.world.plant.contacts == ()
    nothing_moves(portal, 1)


@seeds(1, 5, 50)
def test_it_waits_before_what_stands_in_its_way_and_gives_up(worlds, seed):
    hunt(worlds, seed, blocked)


def driven_at_a_wall(portal):
    """By hand, straight ahead, for as long as somebody holds the stick."""
    portal.grant()
    portal.controls.moment_s = inf
    portal.rig.sim.world.plant.put(1.6, 6.0, pi / 2 + random.Random(portal.world.seed).uniform(-0.3, 0.3))
    command = portal.hold_if_held(portal.issue("drive", forward=1.0, turn=0.0))
    portal.in_motion()
    portal.world.sleep(10)
    plant = portal.rig.sim.world.plant
    assert plant.contacts == (), "it touched the wall"
    assert hall().depth - plant.pose[1] < 0.5, "it came near to it"
    portal.controls.let_go()
    portal.final(command)
    refused = portal.hold_if_held(portal.issue("drive", forward=1.0, turn=0.0))
    portal.world.sleep(1)
    portal.controls.let_go()
    assert portal.final(refused).reason == TOO_NEAR
    back = portal.hold_if_held(portal.issue("drive", forward=-0.5, turn=0.0))
    portal.in_motion()
    portal.world.sleep(2)
    portal.controls.let_go()
    portal.final(back)
    assert hall().depth - plant.pose[1] > 0.5, "it drove back"


@seeds(1, 5, 50)
def test_the_reflex_stops_whoever_drives_at_a_wall(worlds, seed):
    hunt(worlds, seed, driven_at_a_wall)


def turned_away(portal):
    """It stands before a wall, as after a patrol, and is sent to where it came from: it turns, and goes."""
    portal.grant()
    portal.ready_again()
    portal.rig.sim.world.plant.put(*hall().nodes[0].at, -pi / 2)
    wall = portal.final(portal.issue("go", x=1.0, y=0.45), 200)
    assert wall.state == "completed", wall.reason
    portal.rig.sim.world.plant.put(1.0, 0.28, -pi / 2)
    portal.world.sleep(1)
    assert portal.owner.owned.driver.state().values["infrared"] < 0.2
    command = portal.final(portal.issue("go", x=PLACE[0], y=PLACE[1]), 200)
    assert command.state == "completed", command.reason


@seeds(1, 5, 50)
def test_it_turns_away_from_what_it_stands_before(worlds, seed):
    hunt(worlds, seed, turned_away)


def lost_connection(portal):
    portal.grant()
    begin = held if portal.world.seed % 2 else sent
    command = begin(portal)
    at = portal.world.monotonic()
    portal.rig.pull()
    assert rested(portal, at) <= REST_S
    assert portal.rig.journal()[-1]["end"] == "silence"
    assert portal.final(command).state == "failed"
    portal.until(lambda: portal.row.reason, 10, "a word of it")
    portal.world.sleep(random.Random(portal.world.seed).random() * 20)
    portal.rig.plug()
    portal.until(lambda: not portal.row.reason, 60, "another connection")
    portal.controls.let_go()
    nothing_moves(portal, 2)
    assert portal.final(sent(portal), 200).state == "completed"


@seeds(2, 20, 200)
def test_a_lost_connection_holds_the_rover_and_it_is_connected_again(worlds, seed):
    hunt(worlds, seed, lost_connection)


def killed(portal):
    portal.grant()
    command = sent(portal)
    portal.world.sleep(random.Random(portal.world.seed).random())
    at = portal.world.monotonic()
    portal.supervisor.worker.kill()
    assert rested(portal, at) <= REST_S
    assert portal.final(command).state == "unknown"
    portal.until(lambda: portal.owner, 30, "another owner")
    nothing_moves(portal, 6)


@seeds(1, 20, 200)
def test_a_kill_of_its_owner_in_mid_motion(worlds, seed):
    hunt(worlds, seed, killed)


def switched_off(portal):
    portal.grant()
    command = sent(portal)
    portal.rig.power_cycle()
    assert portal.final(command).state == "failed"
    nothing_moves(portal, 1)
    portal.until(lambda: not portal.row.reason, 60, "it is in order again")


@seeds(1, 20, 200)
def test_a_rover_that_loses_its_power_is_connected_again(worlds, seed):
    hunt(worlds, seed, switched_off)


def one_after_another(portal):
    """Motions by hand that wait for one another: the hold that ends one is not taken for the next one's."""
    portal.grant()
    history = Motions(portal)
    for _ in range(5):
        portal.move()
    portal.all_final()
    history.check()


@seeds(1, 20, 200)
def test_the_hold_that_ends_a_motion_does_not_brake_the_next(worlds, seed):
    hunt(worlds, seed, one_after_another)


MISSION = "read\nturn 90\nphotograph\nwait 3\nsay Here begins the tour.\nread\n"


def found(command):
    return list(Finding.objects.filter(command=command).order_by("number"))


def mission(portal):
    """What it finds is stored once, with a picture, in the order in which it was found."""
    portal.grant()
    command = portal.final(portal.issue("mission", text=MISSION), 60)
    assert (command.state, command.result["sent"]) == ("completed", {"steps": 6})
    assert command.result["package"] == sha256(MISSION.encode()).hexdigest()
    told = found(command)
    assert [one.text for one in told] == ["readings", "photograph", "Here begins the tour.", "readings"]
    assert {"temperature", "sonar"} <= set(told[0].values)
    assert told[1].frame.command == command
    assert Frame.objects.filter(command=command).count() == 1


@seeds(1, 10, 100)
def test_a_mission_stores_what_it_finds(worlds, seed):
    hunt(worlds, seed, mission)


def looks_around(portal):
    """Each of the 18 stops leaves its readings and a picture, and the page's pictures tell where the rover looked."""
    portal.grant()
    command = portal.final(portal.issue("mission", text="look around"), 120)
    assert command.state == "completed", command.reason
    told = found(command)
    assert [one.text for one in told] == [f"look {number} of 18" for number in range(1, 19)]
    assert all(set(one.values) == {"compass", "infrared", "sonar"} for one in told)
    turned = [(b.values["compass"] - a.values["compass"]) % 360 for a, b in pairwise(told)]
    assert all(325 < turn < 355 for turn in turned), "20 degrees to the left each, less what slips"
    assert len({one.frame_id for one in told} - {None}) == 18
    for one in told:
        assert abs((one.frame.values["compass"] - one.values["compass"] + 180) % 360 - 180) < 5
    assert [unit for name, _, unit in told[0].readings() if name == "compass"] == ["°"]


@seeds(1, 5, 50)
def test_a_look_around_leaves_18_pictures_with_what_was_read(worlds, seed):
    hunt(worlds, seed, looks_around)


def looks_without_a_camera(portal):
    """A camera that is gone is asked once, and the readings stay."""
    portal.grant()
    portal.rig.fault("cam_gone")
    begun = portal.world.monotonic()
    command = portal.final(portal.issue("mission", text="look around"), 120)
    assert command.state == "completed", command.reason
    told = found(command)
    assert told[0].text == "look 1 of 18: The camera does not answer."
    assert [one.text for one in told[1:]] == [f"look {number} of 18" for number in range(2, 19)]
    assert not any(one.frame for one in told)
    assert portal.world.monotonic() - begun < LOOK_S, "it waited for one picture, not for 18"


@seeds(1, 5, 50)
def test_a_camera_that_is_gone_costs_a_look_around_a_moment(worlds, seed):
    hunt(worlds, seed, looks_without_a_camera)


def killed_in_a_mission(portal):
    """It ends as unknown, at the step where it was; nothing goes on by itself, and its package is gone."""
    portal.grant()
    folder = settings.VAR / "packages" / portal.slug
    command = portal.issue("mission", text="read\nwait 2\nwait 100\n")
    portal.until(lambda: found(command), 30, "the first readings")
    portal.world.sleep(5)
    assert [path.stem for path in folder.glob("*.json")] == [str(command.pk)]
    portal.supervisor.worker.kill()
    ended = portal.final(command)
    assert ended.state == "unknown"
    assert ended.reason.endswith("It was at step 3 of 3: wait 100."), ended.reason
    portal.until(lambda: portal.owner, 30, "another owner")
    nothing_moves(portal, 5)
    assert not list(folder.glob("*.json"))


@seeds(1, 10, 100)
def test_a_mission_that_is_cut_off_says_where_it_was(worlds, seed):
    hunt(worlds, seed, killed_in_a_mission)


def no_room(portal):
    """A machine that cannot store the package moves nothing, and says why."""
    portal.grant()
    folder = settings.VAR / "packages" / portal.slug
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(exist_ok=True)
    folder.write_text("a file where a folder should be")
    try:
        command = portal.final(portal.issue("mission", text=MISSION))
    finally:
        folder.unlink()
    assert (command.state, command.reason) == ("failed", NOT_STORED)
    assert not portal.motions()


@seeds(1, 3, 10)
def test_a_mission_that_cannot_be_stored_moves_nothing(worlds, seed):
    hunt(worlds, seed, no_room)


def without_database(portal):
    """Pictures that were taken while the database was away wait on the machine, and are registered exactly once."""
    portal.grant()
    command = portal.issue("mission", text="read\nphotograph\nread\nwait 60\n")
    world = portal.world
    portal.until(lambda: found(command), 30, "the first readings")
    world.database_away = True
    world.sleep(random.Random(world.seed).random() * 20)
    if world.seed % 2:
        portal.supervisor.worker.kill()
        world.sleep(5)
    world.database_away = False
    portal.final(command)
    portal.until(lambda: portal.owner, 60, "an owner")
    world.sleep(5)
    told = [one.text for one in found(command)]
    assert told == ["readings", "photograph", "readings"][: len(told)]
    assert Frame.objects.filter(command=command).count() == min(len(told) - 1, 1)
    assert len(told) == 3 or world.seed % 2, "nothing was lost"


@seeds(2, 20, 200)
def test_findings_survive_an_outage_of_the_database(worlds, seed):
    hunt(worlds, seed, without_database)
