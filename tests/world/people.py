"""The people of a world: threads that act through the services alone, as pages and sockets do, with their own dice."""

import random
from collections import Counter
from dataclasses import dataclass, field

from operatorlog import services as log
from operatorlog.models import SurveyQuestion
from operatorlog.services import LogError
from queueing import services as queue
from queueing.errors import QueueError
from queueing.models import OPEN_JOB, Job
from queueing.services import Asker, last_turn, standings
from robots import bus, services
from robots.kit.contract.errors import RobotError
from robots.models import Command
from robots.states import COMMAND_FINAL
from tests.world.world import DatabaseAway

REPORT_S = 2.0  # between two reports of an operator's page
PRESENT_S = 10.0  # between two notes of presence on whatever page
REFUSALS = (QueueError, RobotError, LogError)


@dataclass
class Told:
    """The things that a person was told that they have, by primary key, and their own acts that end them."""

    tickets: set[int] = field(default_factory=set)
    turns: set[int] = field(default_factory=set)
    commands: set[int] = field(default_factory=set)
    jobs: set[int] = field(default_factory=set)
    entries: dict[int, str] = field(default_factory=dict)
    answers: set[int] = field(default_factory=set)  # turns of which the survey was answered
    gave_up: set[int] = field(default_factory=set)  # tickets
    cancelled: set[int] = field(default_factory=set)  # jobs
    offers: set[int] = field(default_factory=set)


class Person:
    """Somebody with an account: waits, drives, writes, asks for jobs, goes away and comes back."""

    def __init__(self, crowd, name: str, user) -> None:
        self.crowd, self.name, self.user = crowd, name, type(user).objects.get(pk=user.pk)
        self.portal, self.world, self.robot = crowd.portal, crowd.portal.world, crowd.portal.robot
        self.dice = random.Random(f"{name} {self.world.seed}")
        self.told, self.did = Told(), Counter()
        self.there, self.on_page = True, False  # at any page; at the robot's page
        self.reported_at = self.present_at = self.acted_at = self.world.awake()
        self.longest_absence_s = 0.0
        process = self.world.process(name)
        self.world.spawn(self._live, name, process)
        self.world.spawn(self._page, f"{name}'s page", process)

    @property
    def session(self) -> str:
        return f"session of {self.name}"

    def think(self, most_s: float) -> None:
        self.world.sleep(self.dice.random() * most_s)

    def attempt(self, verb, *args):
        """Ask the portal for something; None where it refuses, or cannot be reached."""
        if not self.crowd.web.up:
            return None
        try:
            return verb(*args)
        except REFUSALS as refusal:
            self.did[type(refusal).__name__] += 1
        except DatabaseAway:
            self.did["no database"] += 1
        return None

    # the page, which reports by itself

    def _page(self) -> None:
        while True:
            self.world.sleep(REPORT_S)
            self.attempt(self._report)

    def _report(self) -> None:
        if not self.there or not self._signed_in():
            return
        now = self.world.now()
        if self.on_page:
            queue.note_presence(self.robot, self.user, now, False, self.session)
        elif self.world.awake() - self.present_at >= PRESENT_S:
            queue.note_waiting(self.user, now)
        else:
            return
        self._note_presence(self.on_page)

    def _note_presence(self, on_page: bool) -> None:
        """Remember when this person was heard of, and for how long nothing was before."""
        at = self.world.awake()
        self.longest_absence_s = max(self.longest_absence_s, at - self.present_at)
        self.present_at = at
        if on_page:
            self.reported_at = at

    def _signed_in(self) -> bool:
        self.user = type(self.user).objects.get(pk=self.user.pk)
        return self.user.is_active

    # the person

    def _live(self) -> None:
        self.think(8.0)
        while True:
            self.there = True
            if not self.crowd.over:
                self.attempt(self._look)
            self.think(3.0)

    def _look(self) -> None:
        if not self._signed_in():
            return
        found = standings(self.user, self.world.now())
        mine = next((one for one in found if one.robot.pk == self.robot.pk), None)
        state = mine.state if mine is not None else "none"
        self.did[state] += 1
        if state in ("waiting", "offered", "operating"):
            self.told.tickets.add(mine.ticket)
        getattr(self, f"_{state}")(mine)

    def _none(self, _) -> None:
        self.on_page = False
        self._write_about_the_last_turn()
        if self.crowd.jobs and self.dice.random() < 0.5:
            self._job()
        elif self.dice.random() < 0.6:
            self.told.tickets.add(queue.join(self.robot, self.user, self.world.now()).pk)
        self.think(self.portal.wishes.pause_s)

    def _waiting(self, mine) -> None:
        chance = self.dice.random()
        if chance < 0.01:
            self._leave(mine.ticket)
        elif chance < 0.02:
            self._go_away(self.dice.choice((30.0, 200.0, 1000.0)))
        elif chance < 0.05 and self.crowd.jobs:
            self._job()

    def _offered(self, mine) -> None:
        self.told.offers.add(mine.ticket)
        chance = self.dice.random()
        if chance < 0.06:
            self._go_away(40.0)
        elif chance < 0.1:
            self._leave(mine.ticket)
        else:
            self.think(6.0)
            away = self.dice.random() < 0.2
            turn = queue.accept(self.robot, self.user, self.world.now(), away)
            self.told.turns.add(turn.pk)
            self.acted_at = self.reported_at = self.world.awake()
            self.think(3.0 if away else 0.2)
            self.on_page = True

    def _operating(self, mine) -> None:
        self.on_page = True
        acts = (
            (40, self._move), (6, self._twice), (5, self._raise), (5, self._hold), (5, self._stop), (8, self._release),
            (4, self._blip), (3, self._lose_the_page), (3, self._stay), (3, lambda: self._leave(mine.ticket)),
            (4, lambda: self.think(8.0)),
        )  # fmt: skip
        self.dice.choices([act for _, act in acts], [weight for weight, _ in acts])[0]()

    def _missed(self, mine) -> None:
        queue.dismiss(mine.ticket, self.user, self.world.now())

    def _ended(self, mine) -> None:
        self.on_page = False
        self._write_about_the_last_turn()
        queue.dismiss(mine.ticket, self.user, self.world.now())

    # what they do

    def _acted(self, made: Command) -> Command:
        self.told.commands.add(made.pk)
        self.acted_at = self.world.awake()
        return made

    def _move(self) -> None:
        made = self._acted(self.crowd.move(self.user))
        if self.dice.random() < 0.8:
            self._await(made)

    def _twice(self) -> None:
        self._await(self._acted(self.crowd.move(self.user, again=2)))

    def _raise(self) -> None:
        wish = self.portal.wishes.spell(self.dice.choice(("up", "down")), {}, None)
        self._acted(self.crowd.issue(self.user, *wish))

    def _await(self, command: Command) -> None:
        """Wait as a person does: not for ever, and longer than most motions take."""
        for _ in range(20):
            self.world.sleep(0.5)
            command.refresh_from_db()
            if command.state in COMMAND_FINAL:
                return

    def _hold(self) -> None:
        made = self._acted(self.crowd.issue(self.user, *self.portal.wishes.jog(self.dice.choice((-1, 1)))))
        for _ in range(self.dice.randrange(3, 12)):
            bus.send_keep_alive(self.robot.slug, made.pk, True)
            self.world.sleep(0.08)
        if self.dice.random() < 0.5:
            bus.send_keep_alive(self.robot.slug, made.pk, False)

    def _stop(self) -> None:
        services.stop(self.robot, self.user, self.world.now())
        queue.note_act(self.robot, self.user, self.world.now())

    def _release(self) -> None:
        if self.portal.row.stop_latched:
            self.think(3.0)
            services.release_stop(self.robot, self.user, checked=True)

    def _blip(self) -> None:
        """Lose the connection for at most 15 s: the turn stays theirs."""
        self._page_closes(self.dice.random() * 15.0)

    def _lose_the_page(self) -> None:
        """Close the page, and open it again when the turn may be over."""
        self._page_closes(20.0 + self.dice.random() * 30.0)

    def _page_closes(self, seconds: float) -> None:
        self.on_page = False
        if self.dice.random() < 0.8:  # else nobody notices that the line is dead
            queue.note_disconnection(self.robot, self.user, self.world.now(), self.session)
        self.world.sleep(seconds)
        self.on_page = True
        self.attempt(self._report)

    def _stay(self) -> None:
        queue.stay(self.robot, self.user, self.world.now())

    def _leave(self, ticket: int) -> None:
        self.told.gave_up.add(ticket)
        queue.leave(self.robot, self.user, self.world.now())
        self.on_page = False

    def _go_away(self, seconds: float) -> None:
        self.there = False
        self.world.sleep(seconds)
        self.there = True
        self.attempt(self._report)

    def _write_about_the_last_turn(self) -> None:
        turn = last_turn(self.robot, self.user)
        if turn is None or turn.pk in self.told.answers or self.dice.random() < 0.3:
            return
        text = f"What {self.name} saw, {self.dice.randrange(10**6)}"
        answers = {q.pk: q.choices()[0] for q in SurveyQuestion.objects.filter(kind="scale", active=True)[:1]}
        entry, response, _ = log.hand_in(turn, self.user, text, None, answers, self.world.now())
        if entry is not None:
            self.told.entries[entry.pk] = text
        if response is not None:
            self.told.answers.add(turn.pk)

    def _job(self) -> None:
        asker, now = Asker(user=self.user), self.world.now()
        mine = Job.objects.filter(user=self.user, robot=self.robot, state__in=OPEN_JOB).order_by("pk").first()
        if mine is not None and self.dice.random() < 0.3:
            self.told.cancelled.add(mine.pk)
            queue.cancel(mine, asker, now)
            return
        form = f"{self.name} {self.dice.randrange(10**9)}"
        kind, args = self.portal.wishes.job(self.robot, self.portal.place(), self.dice)
        made = queue.ask(self.robot, asker, kind, args, now, form=form)
        self.told.jobs.add(made.pk)
        if self.dice.random() < 0.2:
            assert queue.ask(self.robot, asker, kind, args, now, form=form).pk == made.pk, "a second press is a job"
