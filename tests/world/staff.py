"""Staff of a world: kim keeps the robot, by the verbs of its admin page and of the queue."""

import random
from types import SimpleNamespace

from queueing.models import OPEN_TICKET, Ticket, Turn
from queueing.services import end_by_staff, remove_by_staff, resume
from robots.admin import verbs
from robots.kit.contract.errors import RobotError
from robots.states import Cycle
from tests.world.world import DatabaseAway


class Staff:
    """Stops, releases, locks out, removes and suspends, now and then; opens again what it has closed."""

    def __init__(self, crowd, user) -> None:
        self.crowd, self.user = crowd, type(user).objects.get(pk=user.pk)  # who has read no permissions yet
        self.portal, self.world, self.robot = crowd.portal, crowd.portal.world, crowd.portal.robot
        self.dice = random.Random(f"staff {self.world.seed}")
        self.removed: set[int] = set()  # tickets
        self.suspended: set[int] = set()  # people
        self.locked_out = False
        self.world.spawn(self._live, "kim", self.world.process("kim"))

    def _live(self) -> None:
        while True:
            self.world.sleep(5.0 + self.dice.random() * 60.0)
            if self.crowd.web.up and not self.crowd.over:
                try:
                    self._act()
                except (RobotError, DatabaseAway) as refusal:
                    self.world.note(f"kim: {type(refusal).__name__}")

    def verb(self, name: str, **post: str) -> str:
        """Press a button of the robot's admin page; return what it says."""
        row = self.portal.row
        return verbs.VERBS[name](row, SimpleNamespace(user=self.user, POST=post))

    def _act(self) -> None:
        acts = (
            (4, lambda: self.verb("stop")), (4, self._lock_out), (2, self._remove), (1, self._end), (2, self._suspend),
            (2, lambda: self.verb("test")), (8, self.open_again),
        )  # fmt: skip
        self.dice.choices([act for _, act in acts], [weight for weight, _ in acts])[0]()
        self.world.sleep(self.dice.random() * 20.0)
        self.open_again()

    def _lock_out(self) -> None:
        self.locked_out = True
        self.verb("lock_out", note="a look at the sand")
        self.world.sleep(self.dice.random() * 10.0)
        if self.dice.random() < 0.8:
            self.verb("maintenance")
            self.verb("release", checked="yes")
            for _ in range(self.dice.randrange(1, 4)):
                self.crowd.move(self.user)
                self.world.sleep(self.dice.random() * 6.0)

    def _remove(self) -> None:
        tickets = list(Ticket.objects.filter(state__in=OPEN_TICKET).order_by("pk"))
        if tickets:
            chosen = self.dice.choice(tickets)
            self.removed.add(chosen.pk)
            remove_by_staff(chosen, self.user, self.world.now())

    def _end(self) -> None:
        turn = Turn.objects.filter(ended_at=None).first()
        if turn is not None and turn.ticket_id is not None:
            self.removed.add(turn.ticket_id)
            end_by_staff(turn, self.user, self.world.now())

    def _suspend(self) -> None:
        """Switch an account off, as the form of the admin does, and on again."""
        person = self.dice.choice(self.crowd.people)
        self.suspended.add(person.user.pk)
        self._switch(person, on=False)
        self.world.sleep(self.dice.random() * 15.0)
        self._switch(person, on=True)

    def _switch(self, person, on: bool) -> None:
        account = type(person.user).objects.get(pk=person.user.pk)
        account.is_active = on
        account.save(update_fields=["is_active"])

    def open_again(self) -> None:
        """Release, lift and resume what keeps the robot from working."""
        row = self.portal.row
        if row.cycle == Cycle.LOCKED_OUT:
            self.verb("lift")
            row = self.portal.row
        if row.stop_latched:
            self.verb("release", checked="yes")
        resume(row, self.user, self.world.now())
