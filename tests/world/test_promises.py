"""Promises 1 to 5, 7, 10, 11, 14, 22 and 23 in virtual time, one by one; `test_chaos` has them beside each other."""

import random

import pytest

from robots import bus
from robots.models import Command, Grant, Lease
from robots.states import COMMAND_RUNNING, CommandState
from tests.world.chaos import busy
from tests.world.motions import Motions
from tests.world.owner import Worker
from tests.world.seeds import hunt, seeds
from workers.safety.gate import TOO_LATE


@seeds(2, 4, 20)
def test_promise_01_one_command_at_most_one_motion(worlds, proof, seed):
    """Every message arrives two to five times, among two workers that wait for the lease."""
    number = proof.count("commands, each announced 2 to 5 times", 25, 500)

    def run(portal):
        history, dice = Motions(portal), random.Random(seed)
        portal.grant()
        rogues = [Worker(portal.world, portal.slug, portal.rig) for _ in range(2)]
        portal.store.copies = lambda channel: dice.randint(2, 5)
        for i in range(number):
            command = portal.move()
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


@seeds(4, 50, 400)
def test_promise_02_a_crash_means_unknown_never_replay(worlds, proof, seed):
    """The owner is killed at any moment between the press and the end, several times in one run."""
    kills = proof.count("kills", 4, 8)

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


@seeds(2, 10, 60)
@pytest.mark.parametrize("how", ["store silent", "store away", "owner frozen"])
def test_promise_03_late_commands_never_move(worlds, proof, seed, how):
    """What could not begin within its ten seconds never begins."""
    times = proof.count("stalls of 1 to 60 s", 3, 10)

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


@seeds(3, 30, 200)
def test_promise_04_a_frozen_owner_moves_nothing_and_is_killed(worlds, proof, seed):
    """The owner is frozen past its lease in mid-motion; another takes the robot, and the first goes on."""
    times = proof.count("freezes past the lease", 2, 6)

    def run(portal):
        history, dice, world = Motions(portal), random.Random(seed), portal.world
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
                assert portal.final(command, 30).state in ("unknown", "expired"), command.state
            portal.works_on()
        history.check()

    hunt(worlds, seed, run)
    proof.holds(f"{times} freezes past the lease: 0 motions of a stale epoch, each frozen owner killed")


@seeds(3, 20, 100)
def test_promise_05_one_owner_however_many_start(worlds, proof, seed):
    number = proof.count("simultaneous starts", 6, 20)

    def run(portal):
        portal.grant()
        others = [Worker(portal.world, portal.slug, portal.rig) for _ in range(number - 1)]
        portal.world.sleep(20)
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


@seeds(3, 30, 200)
def test_promise_07_with_the_store_dead_the_owner_stops_by_itself(worlds, proof, seed):
    times = proof.count("deaths of the store in mid-motion", 3, 10)
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
    proof.holds(f"{times} deaths of the store: at rest within {worst:.2f} s")


@seeds(3, 20, 100)
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


@seeds(2, 10, 60)
@pytest.mark.parametrize("how", ["noise", "pulled", "halved", "stalls"])
def test_promise_10_a_bad_line_causes_no_wrong_move(worlds, proof, seed, how):
    number = proof.count("commands", 12, 100)

    def run(portal):
        history, dice, rig = Motions(portal), random.Random(seed), portal.rig
        portal.grant()
        if how == "noise":
            for verb in ("drop", "corrupt", "double"):
                if verb in rig.faults:
                    rig.fault(verb, 0.01)
        asked, before = set(), set(history.begun)
        for _ in range(number):
            portal.ready_again()
            command = portal.move()
            asked.add(portal.wishes.goal(command))
            portal.world.sleep(dice.random() * 0.6)
            {"pulled": rig.pull, "halved": rig.halve, "stalls": lambda: rig.stall(dice.random() * 2)}.get(how, int)()
            portal.world.sleep(dice.random())
            rig.plug()
            portal.final(command)
        assert set(history.begun) <= asked | before, "the robot went where nobody sent it"
        history.check()

    hunt(worlds, seed, run)
    proof.holds(f"{how}: {number} commands, 0 wrong or doubled motions")


@seeds(2, 15, 80)
def test_promise_14_a_turn_ends_within_a_second_of_its_deadline(worlds, proof, seed):
    """With nobody but its owner to end it: no web, no housekeeping, and the store alive or dead."""
    times = proof.count("turns", 3, 10)
    worst = 0.0

    def run(portal):
        nonlocal worst
        dice, world = random.Random(seed), portal.world
        for i in range(times):
            seconds = dice.uniform(3, 12)
            portal.grant(seconds)
            begun = world.monotonic()
            kind, args = portal.wishes.jog((-1) ** i)
            command = None
            while world.monotonic() < begun + seconds + 1.5:
                if command is None or command.state in ("cancelled", "completed", "rejected", "expired", "failed"):
                    try:
                        command = portal.issue(kind, **args)
                    except Exception:
                        world.sleep(0.1)
                        continue
                bus.send_keep_alive(portal.slug, command.pk, True)
                world.sleep(0.08)
                command.refresh_from_db()
                if portal.rig.moving:
                    worst = max(worst, world.monotonic() - begun - seconds)
            portal.until(lambda: not Grant.objects.filter(kind="turn", ended_at=None).exists(), 3, "the turn's end")
            portal.at_rest()
        assert worst <= 1.0, f"moving {worst:.2f} s after the end of the turn"

    hunt(worlds, seed, run)
    proof.holds(f"{times} turns with held motions: at rest within {worst:.2f} s of their end")


@seeds(2, 10, 60)
@pytest.mark.parametrize("store", ["store", "database"])
def test_promises_22_and_23_an_outage_is_survived(worlds, seed, store):
    """The robot rests within two seconds (four: the lease), and commands run within fifteen after it, without a human."""

    def run(portal):
        history, dice, world = Motions(portal), random.Random(seed), portal.world
        portal.grant()
        for _ in range(4):
            portal.move()
            portal.in_motion()
            if store == "database":
                world.database_away = True
            else:
                portal.store.up = False
            world.sleep(dice.random() * 10)
            world.sleep(4.0)
            assert not portal.rig.moving
            world.database_away, portal.store.up = False, True
            portal.store.restart()
            back = world.monotonic()
            portal.works_on()
            assert world.monotonic() - back < 15 + 15, "it takes its time"
        history.check()

    hunt(worlds, seed, run)


@seeds(2, 20, 100)
def test_promise_43_a_busy_machine_restarts_nothing(worlds, proof, seed):
    """Threads that come late, again and again: the owner stays, no command ends in a fault, stops are heard."""
    number = proof.count("commands", 15, 200)

    def run(portal):
        history = Motions(portal)
        portal.grant()
        for i in range(number):
            command = portal.final(portal.move())
            assert command.state in ("completed", "cancelled", "rejected", "unknown"), (command.state, command.reason)
            if i % 5 == 4 and command.state != "unknown":
                portal.move()
                portal.world.sleep(0.2)
                portal.stop()
                portal.all_final()
                portal.release()
        assert portal.supervisor.starts == 1
        history.check()

    hunt(worlds, seed, run, lambda seed: busy(seed))
    proof.holds(f"{number} commands while threads are up to 1.5 s late: no restart, no untrue word")
