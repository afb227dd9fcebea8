"""A portal with people, staff, housekeeping and a web process, and what happens to all of them, by a seed."""

import random

from queueing.models import QueueRobot
from queueing.services import job_kinds
from robots import services
from robots.models import Command, Robot
from robots.states import Cycle, GrantKind
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

    def __init__(self, portal, drivers: tuple[str, ...] = DRIVERS, late: bool = False) -> None:
        self.portal, self.world, self.jobs = portal, portal.world, bool(job_kinds(portal.robot))
        self.dice = random.Random(f"crowd {self.world.seed}")
        Robot.objects.filter(pk=portal.robot.pk).update(turn_s=self.turn_s)
        watched = {"rest_after_min": self.dice.choice((0, 15)), "watched_at": self.world.now()}
        QueueRobot.objects.filter(robot=portal.robot).update(**watched)  # at 0 it seldom does anything by itself
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

    # what people and staff do

    def issue(self, user, kind: str, args: dict, again: int = 0) -> Command:
        """Ask for a command as the user, and so many times again with the same number."""
        robot, world = self.portal.robot, self.world
        grant = services.open_grant(robot)
        number = services.next_seq(grant) if grant is not None else 1
        at = world.monotonic()
        made = services.issue(robot.slug, user, kind, args, number, world.now()).command
        self.model.issued.setdefault(made.pk, at)
        for _ in range(again):
            same = services.issue(robot.slug, user, kind, args, number, world.now())
            assert same.command.pk == made.pk, "a command that was sent again is another one"
        return made

    def move(self, user, again: int = 0) -> Command:
        """Ask for a motion to a place where no motion before went."""
        wish = self.portal.wishes.spell("move", self.portal.place(), None)
        return self.portal.hold_if_held(self.issue(user, *wish, again=again))

    def unfinished(self) -> list[Command]:
        """Return the commands that are not over, but for what the robot does while nobody asks for it."""
        return [one for one in super().unfinished() if one.grant.kind != GrantKind.IDLE]

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
