"""A portal with people, staff, housekeeping and a web process, and what happens to all of them, by a seed."""

import random

from robots.models import Robot
from robots.states import Cycle
from tests.world import chaos
from tests.world.chaos import Chaos
from tests.world.housekeeping import Housekeeping, Web
from tests.world.model import Model
from tests.world.people import Person
from tests.world.staff import Staff

DRIVERS = ("ada", "bob", "cy", "dan")
LAST_S = 240.0  # until everything has come into order again


class Crowd(Chaos):
    """One run with people; `troubles` are the names of what may happen to them."""

    turn_s = 25

    def __init__(self, portal, drivers: tuple[str, ...] = DRIVERS, jobs: bool = False, late: bool = False) -> None:
        self.portal, self.world, self.jobs = portal, portal.world, jobs
        self.dice = random.Random(f"crowd {self.world.seed}")
        Robot.objects.filter(pk=portal.robot.pk).update(turn_s=self.turn_s)
        self.web = Web(self.world)
        self.housekeeping = Housekeeping(self.world)
        self.people: list[Person] = []
        self.model = self.history = Model(self)
        self.model.judges_time = not late
        self.over = not drivers  # nobody begins anything new
        self.staff = Staff(self, portal.people["kim"])
        self.people += [Person(self, name, portal.people[name]) for name in drivers]

    def run(self, seconds: float, troubles: tuple[str, ...] = ()) -> None:
        """Let so many seconds pass, with a trouble now and then; then mend everything and judge the history."""
        end = self.world.awake() + seconds
        while self.world.awake() < end:
            self.world.sleep(self.dice.random() * 25.0)
            self.world.check_errors()
            if troubles:
                self.happens(self.dice.choice(troubles))
        self.settle()
        self.model.check()

    def happens(self, what: str) -> None:
        """Let something happen; no time limit is judged meanwhile."""
        self.world.note(what)
        with self.model.disturbed():
            getattr(self, what)()

    def settle(self) -> None:
        """Mend everything, and wait until nothing is open any more that people began."""
        self.heal()
        self.web.up, self.over = True, True
        self.world.thaw(self.housekeeping.process)
        with self.model.disturbed():
            self.portal.until(lambda: not self.unfinished(), 90.0, "the end of every command")

            def in_order() -> bool:
                if self.portal.row.stop_latched or self.portal.row.cycle == Cycle.LOCKED_OUT:
                    self.staff.open_again()
                self.world.sleep(1.0)
                return self.portal.row.cycle in (Cycle.READY, Cycle.OFFERED, Cycle.OPERATING)

            self.portal.until(in_order, LAST_S, "a robot that is in order")
            self.portal.until(self._connected, 60.0, "the connection")
            self.portal.until(lambda: not self.unfinished(), 90.0, "the end of every command")

    def _connected(self) -> bool:
        owner = self.portal.owner
        return owner is not None and owner.connection.connected

    # what happens to the people's side

    def housekeeping_killed(self) -> None:
        self.world.kill(self.housekeeping.process)
        self.world.sleep(1.0 + self.dice.random() * 5.0)
        self.housekeeping = Housekeeping(self.world)

    def housekeeping_frozen(self) -> None:
        self.world.freeze(self.housekeeping.process)
        self.world.sleep(self.dice.random() * 12.0)
        self.world.thaw(self.housekeeping.process)

    def web_away(self) -> None:
        self.web.up = False
        self.world.sleep(self.dice.random() * 30.0)
        self.web.up = True


PEOPLES_SIDE = ("housekeeping_killed", "housekeeping_frozen", "web_away")
EVERYTHING = PEOPLES_SIDE + chaos.STORES + chaos.WIRES + chaos.DEATHS + chaos.CLOCKS
