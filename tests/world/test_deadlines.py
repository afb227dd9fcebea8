"""Promises 14 and 17 in virtual time: what a turn outlasts, and what ends it."""

import random

import pytest

from queueing import services as queue
from queueing.models import Ticket, TicketState, Turn
from robots import services
from robots.kit.contract.errors import GrantOver
from robots.models import Grant, Robot
from robots.states import GrantEnd
from tests.world.crowd import Crowd
from tests.world.seeds import hunt, seeds

TICK_S = 1.2  # from tick to tick, and the tick itself
BY_ITS_OWNER_S = 2.4  # who waits for a tick


class Page:
    """A page of somebody whom the test itself lets act: it reports while it is `open`."""

    def __init__(self, portal, name: str) -> None:
        self.portal, self.world, self.user = portal, portal.world, portal.people[name]
        self.open = True
        self.world.spawn(self._report, f"{name}'s page", self.world.process(name, delayed=False))
        queue.join(portal.robot, self.user, self.world.now())

    def _report(self) -> None:
        while True:
            self.world.sleep(2.0)
            if self.open:
                queue.note_presence(self.portal.robot, self.user, self.world.now(), False, "a session")

    @property
    def state(self) -> str:
        return Ticket.objects.filter(user=self.user).latest("pk").state

    def accept(self, seconds: float = 120.0) -> Turn:
        self.portal.until(lambda: self.state == TicketState.OFFERED, seconds, "an offer")
        return queue.accept(self.portal.robot, self.user, self.world.now())

    def away(self, seconds: float) -> None:
        """Close for so long."""
        self.open = False
        queue.note_disconnection(self.portal.robot, self.user, self.world.now(), "a session")
        self.world.sleep(seconds)
        self.open = True
        queue.note_presence(self.portal.robot, self.user, self.world.now(), False, "a session")


def begun(portal, turn_s: int, *names: str) -> tuple[Crowd, list[Page]]:
    """Begin housekeeping and web, and let these people join one after another."""
    crowd = Crowd(portal, drivers=())
    Robot.objects.filter(pk=portal.robot.pk).update(turn_s=turn_s)
    return crowd, [Page(portal, name) for name in names]


@seeds(1, 40, 400)
def test_promise_14_a_turn_ends_though_nobody_looks(crowds, proof, seed):
    """Nobody drives after the deadline; its row follows with a tick, or by its owner while no tick comes."""
    worst = 0.0

    def run(portal):
        nonlocal worst
        dice, world = random.Random(seed), portal.world
        crowd, (ada, _) = begun(portal, dice.randrange(10, 30), "ada", "bob")
        turn = ada.accept()
        until = Grant.objects.get(pk=turn.grant_id).until
        world.sleep((until - world.now()).total_seconds() - dice.random() * 4.0)
        gone = dice.sample(("ticks", "web", "store"), dice.randrange(1, 4))
        crowd.web.up = "web" not in gone
        portal.store.up = "store" not in gone
        if "ticks" in gone:
            world.kill(crowd.housekeeping.process)
        world.sleep((until - world.now()).total_seconds())
        with pytest.raises(GrantOver):
            services.issue(portal.slug, ada.user, *portal.wishes.spell("move", portal.place(), None), 77, world.now())
        portal.until(lambda: Grant.objects.get(pk=turn.grant_id).ended_at, 30, "the end of the turn")
        late_s = (world.now() - until).total_seconds()
        worst = max(worst, late_s)
        assert late_s <= (BY_ITS_OWNER_S if "ticks" in gone else TICK_S), f"{late_s:.2f} s late, without {gone}"

    hunt(crowds, seed, run)
    proof.holds(f"without ticks, web or store it ended {worst:.2f} s after its deadline", worst)


@seeds(1, 40, 400)
def test_promise_17_blips_are_forgiven_and_absence_is_not(crowds, proof, seed):
    def run(portal):
        dice, world = random.Random(seed), portal.world
        _, (ada, bob, cy) = begun(portal, 600, "ada", "bob", "cy")
        turn = ada.accept()
        for _ in range(3):
            ada.away(dice.random() * 15.0)
            world.sleep(dice.random() * 10.0)
            turn.refresh_from_db()
            assert turn.ended_at is None, turn.end_reason
        gone = world.monotonic()
        world.spawn(lambda: ada.away(60.0), "ada goes", world.process("ada goes"))
        portal.until(lambda: Turn.objects.get(pk=turn.pk).ended_at, 25, "the end of her turn")
        assert 19.0 <= world.monotonic() - gone <= 22.0, world.monotonic() - gone
        assert Grant.objects.get(pk=turn.grant_id).end_code == GrantEnd.ABSENT
        portal.until(lambda: bob.state == TicketState.OFFERED, 60, "the next offer")
        offered = world.monotonic()
        portal.until(lambda: cy.state == TicketState.OFFERED, 40, "that it is passed on")
        assert bob.state == TicketState.EXPIRED
        assert 29.0 <= world.monotonic() - offered <= 33.0, world.monotonic() - offered
        assert cy.accept()

    hunt(crowds, seed, run)
    proof.holds("three lost lines of at most 15 s kept the turn, one of 20 s ended it; no answer in 30 s was passed on")
