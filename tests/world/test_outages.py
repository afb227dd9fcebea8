"""Promises 14, 22, 23 and 43 in virtual time: a turn's end, outages of the stores, and a busy machine."""

import random

from robots import bus
from robots.models import Grant
from tests.world.chaos import busy
from tests.world.motions import Motions
from tests.world.portal import EACH
from tests.world.seeds import hunt, seeds


@EACH
@seeds(1, 15, 80)
def test_promise_14_a_turn_ends_within_a_second_of_its_deadline(worlds, proof, seed):
    """With nobody but its owner to end it: no web, no housekeeping, and the store alive or dead."""
    times = proof.count("turns", 2, 10)
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
    proof.holds(f"{times} turns with held motions: at rest within {worst:.2f} s of their end", worst)


def outages(portal, times, goes, comes):
    """Let a store go and come back in mid-motion; return how long it took until the next motion was completed (s)."""
    history, dice, world = Motions(portal), random.Random(portal.world.seed), portal.world
    portal.grant()
    worst = 0.0
    for _ in range(times):
        portal.move()
        portal.in_motion()
        goes()
        world.sleep(4.0 + dice.random() * 10)  # the lease, and braking
        assert not portal.rig.moving
        comes()
        back = world.monotonic()
        portal.works_on()
        worst = max(worst, world.monotonic() - back)
    assert worst < 15.0, f"commands ran {worst:.1f} s after the store was back"
    history.check()
    return worst


@EACH
@seeds(1, 10, 60)
def test_promise_22_an_outage_of_the_store_is_survived(worlds, proof, seed):
    times, worst = proof.count("outages in mid-motion", 2, 8), []

    def run(portal):
        store = portal.store

        def comes():
            store.restart()
            store.up = True

        worst.append(outages(portal, times, lambda: setattr(store, "up", False), comes))

    hunt(worlds, seed, run)
    proof.holds(f"{times} outages: at rest meanwhile, the next motion completed within {max(worst):.1f} s", max(worst))


@EACH
@seeds(1, 10, 60)
def test_promise_23_an_outage_of_the_database_is_survived(worlds, proof, seed):
    times, worst = proof.count("outages in mid-motion", 2, 8), []

    def run(portal):
        def away(yes):
            portal.world.database_away = yes

        worst.append(outages(portal, times, lambda: away(True), lambda: away(False)))

    hunt(worlds, seed, run)
    proof.holds(f"{times} outages: at rest meanwhile, the next motion completed within {max(worst):.1f} s", max(worst))


@EACH
@seeds(1, 20, 100)
def test_promise_43_a_busy_machine_restarts_nothing(worlds, proof, seed):
    """Threads that come late, again and again: the owner stays, no command ends in a fault, stops are heard."""
    number = proof.count("commands", 6, 200)

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
