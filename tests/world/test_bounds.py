"""Promises 9, 44 and 48 in virtual time: values and clients that must move nothing, and stops that nobody confirms."""

import math
import random
from datetime import timedelta

import pytest

from robots import bus, services
from robots.kit.contract.errors import RobotError
from robots.models import Command, Lease
from robots.services import START_S
from robots.services.stopping import stop_shown
from tests.conftest import at_length
from tests.world.motions import Motions
from tests.world.portal import EACH
from tests.world.seeds import hunt, seeds

WILD = (1e308, -1e308, True, None, "0.1", [0.1], {"x": 1}, 2**63)  # a row can hold them
WILDER = (*WILD, math.nan, math.inf, -math.inf)


def spoilt(portal, dice, values):
    """Return a motion of which one value is none: wild, or a little beyond its bounds."""
    kind, args = portal.wishes.spell("move", portal.place(), None)
    known = {argument.name: argument for argument in portal.robot.spec().command(kind).arguments}
    name = dice.choice(sorted(args))
    beyond = (known[name].low - 0.001, known[name].high + 0.001)
    return kind, {**args, name: dice.choice((*values, *beyond))}


def past_the_server(portal, kind, args) -> Command:
    """Write the row of a command that the server did not look at, and wake the owner."""
    grant, now = services.open_grant(portal.robot), portal.world.now()
    epoch = Lease.objects.get().epoch
    made = Command.objects.create(
        robot=portal.robot, grant=grant, client_seq=services.next_seq(grant), issued_by=portal.people["ada"],
        kind=kind, args=args, epoch=epoch, created_at=now, deadline=now + timedelta(seconds=START_S), limit_s=30.0,
    )  # fmt: skip
    bus.wake_owner(portal.slug, epoch)
    return portal.hold_if_held(made)


@EACH
@seeds(1, 10, 50)
def test_promise_09_a_value_outside_its_bounds_moves_nothing(worlds, proof, seed):
    """Asked of the server, which refuses it, and past the server of the owner, between motions that are carried out."""
    number = proof.count("commands of which a value is wild", 8, 400)

    def run(portal):
        dice = random.Random(seed)
        portal.grant()
        for i in range(number):
            begun = portal.rig.count("motion")
            kind, args = spoilt(portal, dice, WILDER)
            with pytest.raises(RobotError):
                services.issue(portal.slug, portal.people["ada"], kind, args, 10_000 + i)
            kind, args = spoilt(portal, dice, WILD)
            command = portal.final(past_the_server(portal, kind, args))
            assert command.state == "rejected", (command.state, command.reason, args)
            assert command.reason
            assert portal.rig.count("motion") == begun, f"{args} moved the robot"
            if i % 8 == 0:
                portal.works_on()
        assert portal.rig.count("passed") == 0

    hunt(worlds, seed, run)
    proof.holds(f"{number} at the server and {number} past it: 0 motions")


@EACH
@seeds(1, 10, 50)
def test_promise_44_a_hostile_client_beside_the_owner_changes_nothing(worlds, proof, seed):
    """Somebody else on the robot's wire says what nobody may, while the owner carries out commands."""
    number = proof.count("commands beside a hostile client", 3, 60)

    def run(portal):
        history, dice, world = Motions(portal), random.Random(seed), portal.world
        portal.grant()
        before = set(history.begun)

        def meddle():
            while True:
                world.sleep(dice.random() * 0.2)
                portal.rig.meddle(dice)

        world.spawn(meddle, "hostile", world.process("hostile"))
        for _ in range(number):
            command = portal.final(portal.move())
            assert command.state == "completed", command.reason
        assert len(history.begun.keys() - before) == number
        assert portal.supervisor.starts == 1
        assert all(portal.rig.count(event) == 0 for event in ("crash", "thread_died", "passed"))
        history.check()

    hunt(worlds, seed, run)
    proof.holds(f"{number} commands beside a hostile client: {number} motions, 0 crashes")


@EACH
@seeds(1, 20, 100)
@pytest.mark.parametrize("how", ["killed", at_length("stalled"), at_length("mute")])
def test_promise_48_nobody_says_that_a_robot_rests_before_it_does(worlds, proof, seed, how):
    """A stop that the robot does not confirm, or for which no owner is left, says until when it may move at most."""
    times = proof.count("stops that nobody confirms", 1, 5)

    def run(portal):
        dice, world, rig = random.Random(seed), portal.world, portal.rig
        portal.grant()

        def shown():
            said = stop_shown(portal.row, world.now())
            if said is not None and (said.confirmed or (said.rests_by and world.now() > said.rests_by)):
                assert not rig.moving, f"it moves, and is said to rest: {said}"
            return said

        for _ in range(times):
            portal.move()
            portal.in_motion()
            world.sleep(dice.random() * 0.3)
            rig.fault("mute") if how == "mute" else rig.stall(60.0)
            if how == "killed":
                portal.supervisor.worker.kill()
            services.stop(portal.robot, portal.people["ada"])
            said = portal.until(lambda: (told := shown()) and told.rests_by and told, 30, "the time by which it rests")
            assert not said.confirmed
            while world.now() <= said.rests_by:
                world.sleep(0.2)
                shown()
            assert not rig.moving
            rig.stall(0.0)
            rig.clear_faults()
            portal.until(lambda: (told := shown()) and told.confirmed, 90, "the robot's own word")
            portal.release()
            portal.all_final()
            portal.works_on()

    hunt(worlds, seed, run)
    proof.holds(f"{how}: {times} stops were not confirmed, and the robot rested by the time that was shown")
