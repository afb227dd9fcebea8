"""Promises 1 to 5 and 7 in virtual time, one by one; `test_chaos` has them beside each other."""

import random

import pytest

from robots import bus, services
from robots.models import Command, Lease
from robots.states import COMMAND_RUNNING, CommandState
from tests.world.motions import WIRE_S, Motions
from tests.world.owner import Worker
from tests.world.portal import ALL, EACH
from tests.world.seeds import hunt, seeds
from workers.authority.gate import TOO_LATE

MOST_MOMENTS = 8.0  # of an owner while a command of a moment runs: a power of two


@EACH
@seeds(1, 4, 20)
def test_promise_01_one_command_at_most_one_motion(worlds, proof, seed):
    """Every message arrives two to five times, among two workers that wait for the lease."""
    number = proof.count("commands, each announced 2 to 5 times", 10, 500)

    def run(portal):
        history, dice = Motions(portal), random.Random(seed)
        portal.grant()
        rogues = [Worker(portal.world, portal.slug, portal.rig) for _ in range(2)]
        portal.store.copies = lambda channel: dice.randint(2, 5)
        for i in range(number):
            command = portal.move()
            again = services.issue(portal.slug, command.issued_by, command.kind, command.args, command.client_seq)
            assert (again.command.pk, again.created) == (command.pk, False), "the same number is the same command"
            for _ in range(dice.randint(1, 4)):
                bus.wake_owner(portal.slug, portal.owner.lease.epoch)
            if i % 3 == 2 or portal.wishes.one_at_a_time:
                portal.all_final()
        portal.all_final()
        assert {one.state for one in history.commands()} == {"completed"}
        assert [history.begun[portal.wishes.goal(one)] for one in history.commands()] == [1] * number
        assert not any(rogue.owner for rogue in rogues)
        history.check()

    hunt(worlds, seed, run)
    proof.holds(f"{number} commands announced several times among two rogue workers: {number} motions")


@ALL
@seeds(1, 50, 400)
def test_promise_02_a_crash_means_unknown_never_replay(worlds, proof, seed):
    """The owner is killed at any moment between the press and the end, several times in one run."""
    kills = proof.count("kills", 3, 8)

    def run(portal):
        history, dice, world = Motions(portal), random.Random(seed), portal.world
        portal.grant()
        for _ in range(kills):
            command, epoch = portal.move(), portal.owner.lease.epoch
            if dice.random() < 0.6:
                portal.in_motion()
                world.sleep(dice.random() * 0.8)
            else:
                world.sleep(dice.random() * 0.08)
            portal.supervisor.worker.kill()
            begun = history.begun[portal.wishes.goal(command)]
            portal.at_rest()
            portal.until(lambda epoch=epoch: Lease.objects.get().epoch > epoch, 20, "the next owner")
            portal.final(command, 20)
            assert begun <= 1
            if begun:
                assert command.state == CommandState.UNKNOWN
                assert "not known" in command.reason
            portal.until(
                lambda: not Command.objects.filter(state__in=COMMAND_RUNNING).exists(), 10, "no running command"
            )
            portal.works_on()
        history.check()

    hunt(worlds, seed, run)
    proof.holds(f"{kills} kills: 0 replays")


@EACH
@seeds(1, 20, 200)
def test_promise_02_killed_before_any_wait_or_statement(worlds, proof, seed):
    """Between any two steps of a command's life, from its wake-up to its end: also where no time passes."""
    kills = proof.count("kills", 4, 8)

    def run(portal):
        history, dice, world = Motions(portal), random.Random(seed), portal.world
        portal.grant()
        for _ in range(kills):
            worker, epoch = portal.supervisor.worker, portal.owner.lease.epoch
            world.at_moment(worker.process, int(2 ** (dice.random() * MOST_MOMENTS)), worker.kill)
            command = portal.move()
            portal.until(lambda worker=worker: worker.ended, 30, "the death")
            world.sleep(WIRE_S)
            begun = history.begun[portal.wishes.goal(command)]
            portal.at_rest()
            portal.until(lambda epoch=epoch: Lease.objects.get().epoch > epoch, 20, "the next owner")
            portal.final(command, 20)
            assert history.begun[portal.wishes.goal(command)] == begun <= 1
            assert not begun or command.state in ("unknown", "completed", "cancelled"), command.state
            portal.until(
                lambda: not Command.objects.filter(state__in=COMMAND_RUNNING).exists(), 10, "no running command"
            )
            portal.works_on()
        history.check()

    hunt(worlds, seed, run)
    proof.holds(f"{kills} kills: 0 replays")


@EACH
@seeds(1, 20, 200)
def test_promise_03_claimed_in_time_but_said_too_late(worlds, proof, seed, settings):
    """The owner freezes before any wait or statement, keeps its lease, and goes on after the deadline."""
    settings.FARHAND = {**settings.FARHAND, "LEASE_S": 60, "REDIS_GONE_S": 60}  # the deadline alone is looked at
    times = proof.count("freezes past the deadline", 3, 10)

    def run(portal):
        history, dice, world = Motions(portal), random.Random(seed), portal.world
        portal.grant()
        for _ in range(times):
            process = portal.supervisor.worker.process
            world.at_moment(process, dice.randrange(1, 20), lambda process=process: world.freeze(process))
            command = portal.move()
            history.issued[command.pk] = world.monotonic()
            world.sleep(11.0)
            assert process.frozen
            world.thaw(process)
            portal.final(command)
            assert portal.supervisor.starts == 1
            portal.works_on()
        history.check()

    hunt(worlds, seed, run)
    proof.holds(f"{times} freezes past the deadline: 0 motions past it")


@EACH
@seeds(1, 10, 60)
@pytest.mark.parametrize("how", ["store silent", "store away", "owner frozen"])
def test_promise_03_late_commands_never_move(worlds, proof, seed, how):
    """A command that could not begin within its ten seconds never begins."""
    times = proof.count("stalls of 1 to 60 s", 2, 10)

    def run(portal):
        history, dice, world = Motions(portal), random.Random(seed), portal.world
        portal.grant()
        for _ in range(times):
            seconds = dice.choice((1.0, 9.0, 12.0, 60.0)) * dice.uniform(0.8, 1.0)
            worker = portal.supervisor.worker
            waiting = [portal.move() for _ in range(2)]
            if how == "owner frozen":
                world.freeze(worker.process)
            portal.store.up, portal.store.silent = how != "store away", how == "store silent"
            world.sleep(dice.random() * 0.1)
            waiting += [portal.move() for _ in range(2)]
            for command in waiting:
                history.issued[command.pk] = world.monotonic()
            world.sleep(seconds)
            world.thaw(worker.process)
            portal.store.up, portal.store.silent = True, False
            for command in waiting:
                portal.final(command)
                late = command.state == "expired"
                assert not late or command.reason == TOO_LATE or command.epoch != portal.owner.lease.epoch
                assert not late or not history.begun[portal.wishes.goal(command)], "an expired command moved"
            portal.works_on()
        history.check()

    hunt(worlds, seed, run)
    proof.holds(f"{how}: {times} stalls of up to 60 s: 0 motions past their deadline")


@ALL
@seeds(1, 30, 200)
def test_promise_04_a_frozen_owner_moves_nothing_and_is_killed(worlds, proof, seed):
    """The owner is frozen past its lease in mid-motion; another takes the robot, and the first goes on."""
    times = proof.count("freezes past the lease", 2, 6)

    def run(portal):
        history, dice, world = Motions(portal), random.Random(seed), portal.world
        ends = {"unknown", "expired"} | ({"cancelled"} if portal.wishes.one_at_a_time else set())  # by a newer one
        portal.grant()
        for _ in range(times):
            first, epoch = portal.supervisor.worker, portal.owner.lease.epoch
            waiting = [portal.move() for _ in range(3)]
            portal.in_motion()
            world.sleep(dice.random() * 0.5)
            world.freeze(first.process)
            portal.supervisor.worker = Worker(world, portal.slug, portal.rig)
            portal.until(lambda epoch=epoch: Lease.objects.get().epoch > epoch, 30, "the next owner")
            assert first.ended, "the frozen owner has the device, so it is killed first"
            world.thaw(first.process)
            portal.ready_again()
            for command in waiting:
                assert portal.final(command, 30).state in ends, command.state
            portal.works_on()
        history.check()

    hunt(worlds, seed, run)
    proof.holds(f"{times} freezes past the lease: 0 motions of a stale epoch, each frozen owner killed")


@EACH
@seeds(1, 20, 200)
def test_promise_04_an_owner_that_goes_on_after_its_lease_moves_nothing_before_it_has_the_next(
    worlds, proof, seed, settings
):
    """Frozen before any wait or statement; nobody else takes the robot, so it takes it again."""
    settings.FARHAND = {**settings.FARHAND, "REDIS_GONE_S": 60}  # the lease alone is looked at
    times = proof.count("freezes past the lease", 6, 10)

    def run(portal):
        history, dice, world = Motions(portal), random.Random(seed), portal.world
        portal.grant()
        for _ in range(times):
            process = portal.supervisor.worker.process
            world.at_moment(process, int(2 ** (dice.random() * 5)), lambda process=process: world.freeze(process))
            command = portal.move()
            portal.until(lambda process=process: process.frozen, 5, "the freeze")
            world.sleep(4.0 + dice.random() * 3)
            command.refresh_from_db()
            ran = command.state in ("sent", "acknowledged")
            world.thaw(process)
            portal.final(command)
            assert not ran or command.state == "unknown", f"its robot was nobody's for a while: {command.state}"
            portal.works_on()
        history.check()

    hunt(worlds, seed, run)
    proof.holds(f"{times} freezes past the lease: 0 motions without one")


@EACH
@seeds(1, 20, 100)
def test_promise_05_one_owner_however_many_start(worlds, proof, seed):
    number = proof.count("simultaneous starts", 6, 20)

    def run(portal):
        portal.grant()
        others = [Worker(portal.world, portal.slug, portal.rig) for _ in range(number - 1)]
        portal.world.sleep(20)
        assert not any(one.ended for one in (portal.supervisor.worker, *others)), "one was killed for its robot"
        owners = [worker for worker in (portal.supervisor.worker, *others) if worker.owner and not worker.ended]
        assert [one.owner.lease.epoch for one in owners] == [Lease.objects.get().epoch]
        portal.works_on()
        for worker in (portal.supervisor.worker, *others)[: number // 2]:
            worker.kill()
        portal.supervisor.worker = next((one for one in others if not one.ended), portal.supervisor.worker)

        def one_has_it():
            living = [worker for worker in others if worker.owner and not worker.ended]
            assert len(living) <= 1
            return living and living[0].owner.connection.connected

        if others[-1].ended:
            return
        portal.until(one_has_it, 60, "the next owner")

    hunt(worlds, seed, run)
    proof.holds(f"{number} simultaneous starts: one owner")


@EACH
@seeds(1, 30, 200)
def test_promise_07_with_the_store_dead_the_owner_stops_by_itself(worlds, proof, seed):
    times = proof.count("deaths of the store in mid-motion", 2, 10)
    worst = 0.0

    def run(portal):
        nonlocal worst
        dice, world = random.Random(seed), portal.world
        portal.grant()
        for _ in range(times):
            for _ in range(3):
                portal.move()
            portal.in_motion()
            world.sleep(dice.random() * 0.3)
            at = world.monotonic()
            setattr(portal.store, *dice.choice((("up", False), ("silent", True))))
            portal.at_rest()
            world.sleep(1.0)
            portal.at_rest()
            portal.until(lambda at=at: world.monotonic() > at + 2.0, 5, "two seconds")
            assert not portal.rig.moving
            worst = max(worst, max((r["t"] for r in portal.rig.journal() if r["event"] == "rest"), default=at) - at)
            portal.world.sleep(dice.random() * 10)
            assert not portal.rig.moving
            portal.store.up, portal.store.silent = True, False
            portal.all_final()
            portal.works_on()
        assert worst <= 2.0, f"at rest {worst:.2f} s after the store's death"

    hunt(worlds, seed, run)
    proof.holds(f"{times} deaths of the store: at rest within {worst:.2f} s", worst)


@EACH
@seeds(1, 20, 100)
def test_promise_07_the_latch_survives_a_death_of_everything(worlds, proof, seed):
    times = proof.count("deaths while stopped", 2, 5)

    def run(portal):
        dice, world = random.Random(seed), portal.world
        portal.grant()
        for _ in range(times):
            portal.move()
            portal.in_motion()
            bus.send_stop(portal.slug)
            portal.until(lambda: portal.owner.latch.latched, 2, "the latch")
            world.sleep(dice.random() * 0.2)
            portal.supervisor.worker.kill()
            portal.store.restart()
            begun = len(portal.motions())
            portal.until(lambda: portal.owner and portal.owner.connection.connected, 60, "the next owner")
            assert portal.owner.latch.latched
            world.sleep(5)
            assert len(portal.motions()) <= begun
            portal.release()
            portal.all_final()
            portal.works_on()

    hunt(worlds, seed, run)
    proof.holds(f"{times} deaths of the owner and the store while stopped: stopped until the release")
