"""The rules of people's turns, places and commands, judged while a world runs and when it is over.

Each rule writes what cannot be into `wrong`. Times are judged by the world's clock that stands still while the machine
sleeps; a time limit counts only where nothing was away, frozen or killed (`disturbed`).
"""

from collections import Counter, defaultdict
from contextlib import contextmanager
from itertools import pairwise
from math import inf, isclose

from django.conf import settings
from django.db.models import F

from operatorlog.models import Entry, SurveyResponse
from queueing.models import OPEN_JOB, OPEN_TICKET, Account, Job, JobState, PlaceEnd, Ticket, TicketState, Turn
from robots.models import Command, Grant
from robots.services import START_S
from robots.states import COMMAND_FINAL, CommandState, GrantEnd
from tests.world.motions import WIRE_S, Motions

RULES = settings.FARHAND
EVERY_S = 0.4
AFTER_S = 10.0  # after its limit a command is final
TURN_S = 1.2  # after its deadline the row of a grant is ended, by a tick; nobody may drive any more before
TICK_S = 2.5  # by which the row of a turn or an offer may come after that of its grant, which may be late itself
CALM_S = 20.0  # after a disturbance, until everything is in order again
EARLY_S = 2.5  # a time that is measured by repeated looks may seem shorter


class Model(Motions):
    """Judges one crowd."""

    look_s = 0.1

    def __init__(self, crowd) -> None:
        super().__init__(crowd.portal)
        self._crowd = crowd
        self.rested: Counter[object] = Counter()  # motions that came to their end, by goal
        self._goal_of: dict[int, object] = {}  # by the number of an instruction
        self.judges_time = True  # whether threads come when their time is up
        self._disturbed = 0
        self._calm_at = -inf
        self._lost_s = 0.0  # for how long something was disturbed so far
        self._commands: dict[int, tuple[float, float]] = {}  # unfinished: since when, and what was lost until then
        self._turns: dict[int, float] = {}  # since when each is open
        self.lasted_s: dict[int, float] = {}  # how long each turn was open
        self.unheard_s: dict[int, float] = {}  # for how long its page had not reported at the end of each turn
        self._offers: dict[int, float] = {}  # since when each place is offered
        self.offered_s: dict[int, float] = {}  # how long each was, the last time
        self._said: set[tuple] = set()
        world = self._world
        world.spawn(self._look_on, "model", world.host)  # it finds the database when nobody else does

    # disturbances

    @contextmanager
    def disturbed(self):
        """Judge no time limit meanwhile, and for a moment after it."""
        self._disturbed += 1
        begun = self._world.awake()
        try:
            yield
        finally:
            self._disturbed -= 1
            self._calm_at = self._world.awake() + CALM_S
            self._lost_s += self._world.awake() - begun + CALM_S

    @property
    def calm(self) -> bool:
        return self.judges_time and not self._disturbed and self._world.awake() >= self._calm_at

    def say(self, rule: str, key: object, text: str) -> None:
        """Note what cannot be, once."""
        if (rule, key) not in self._said:
            self._said.add((rule, key))
            self.wrong.append(f"{self._world.monotonic():.2f} s: {text}")

    # motions

    def _noted(self, record: dict) -> None:
        rig = self._portal.rig
        if record["event"] == "motion":
            self._judge_permission(record)
            self._goal_of[rig.number_of(record)] = self._portal.wishes.made(record) if self._of_a_move(record) else None
        elif rig.confirms(record):
            self.rested[self._goal_of.get(rig.number_of(record))] += 1
        super()._noted(record)

    def _begins(self, record: dict) -> None:
        if self._of_a_move(record):
            super()._begins(record)

    def _of_a_move(self, record: dict) -> bool:
        return self._portal.rig.kind_of(record) in self._portal.wishes.moves

    def _judge_permission(self, record: dict) -> None:
        """Let no motion begin without an open grant, whoever began it."""
        if Grant.objects.filter(ended_at=None).exists() or self.clock_set:
            return
        last = Grant.objects.order_by("-ended_at").first()
        since_s = (self._world.now() - last.ended_at).total_seconds() if last is not None else inf
        if since_s > WIRE_S + max(0.0, self._portal.rig.stalled_s):
            self.say("grant", record["t"], f"the motion {record} began without a grant")

    # while it runs

    def _look_on(self) -> None:
        while True:
            self._world.sleep(EVERY_S)
            self._look()

    def _look(self) -> None:
        now, at = self._world.now(), self._world.awake()
        grants = list(Grant.objects.filter(ended_at=None).values_list("pk", "until", "kind"))
        turns = list(Turn.objects.filter(ended_at=None).values_list("pk", "until", "user", "ticket"))
        if len(grants) > 1:
            self.say("grants", tuple(grants), f"{len(grants)} grants are open: {grants}")
        if len(turns) > 1:
            self.say("turns", tuple(turns), f"{len(turns)} turns are open: {turns}")
        for pk, until, kind in grants:
            late_s = (now - until).total_seconds() if until is not None else -inf
            if late_s > TURN_S and self.calm:
                self.say("until", pk, f"the grant {pk} ({kind}) is open {late_s:.2f} s after its end")
        heard = {person.user.pk: person.reported_at for person in self._crowd.people}
        for pk, until, user, _ in turns:
            self.lasted_s[pk] = at - self._turns.setdefault(pk, at)
            self.unheard_s[pk] = at - heard.get(user, at)
            late_s = (now - until).total_seconds()
            if late_s > TURN_S + TICK_S and self.calm:
                self.say("turn", pk, f"the turn {pk} runs {late_s:.2f} s after its end")
        self._look_at_offers(now, at)
        self._look_at_commands(at)

    def _look_at_offers(self, now, at: float) -> None:
        offers = dict(Ticket.objects.filter(state=TicketState.OFFERED).values_list("pk", "offer_until"))
        for pk, until in offers.items():
            since = self._offers.setdefault(pk, at)
            self.offered_s[pk] = at - since
            late_s = (now - until).total_seconds()
            if late_s > TICK_S and self.calm:
                self.say("offer", pk, f"the place {pk} is offered {late_s:.2f} s after the end of the offer")
        for pk in self._offers.keys() - offers.keys():
            del self._offers[pk]

    def _look_at_commands(self, at: float) -> None:
        found = dict(Command.objects.exclude(state__in=COMMAND_FINAL).values_list("pk", "limit_s"))
        for pk in self._commands.keys() - found.keys():
            del self._commands[pk]
        for pk, limit_s in found.items():
            since, lost_s = self._commands.setdefault(pk, (at, self._lost_s))
            most_s = START_S + limit_s + AFTER_S + self._lost_s - lost_s
            if at - since > most_s and self.calm:
                self.say("final", pk, f"the command {pk} is not final {at - since:.1f} s after it was asked for")

    # when it is over

    def check(self) -> None:
        for command in self.commands().filter(state=CommandState.COMPLETED):
            goal = self._portal.wishes.goal(command)
            if not self.rested[goal]:
                self.wrong.append(
                    f"the command {command.pk} is completed, and the robot's motion never came to its end"
                )
        self._check_intervals()
        for turn in Turn.objects.exclude(ended_at=None).select_related("grant"):
            self._check_turn(turn)
        for person in self._crowd.people:
            self._check_told(person)
        self._check_jobs()
        for account in Account.objects.filter(user__isnull=False):
            self._check_charge(account)
        super().check()

    def _check_intervals(self) -> None:
        """Let no two grants of the robot, and no two turns, have been open at the same time."""
        if self.clock_set:
            return
        for model, begin in ((Grant, "opened_at"), (Turn, "started_at")):
            rows = list(model.objects.order_by("pk").values_list("pk", begin, "ended_at"))
            for (one, _, ended), (other, opened, _) in pairwise(rows):
                if ended is None or ended > opened:
                    self.wrong.append(f"{model.__name__} {other} was opened at {opened}, before {one} ended at {ended}")
            wrong = model.objects.filter(ended_at__lt=F(begin))
            self.wrong += [f"{model.__name__} {one.pk} ended before it began" for one in wrong]

    def _check_turn(self, turn: Turn) -> None:
        """Let a turn have ended only for what happened."""
        code, crowd = GrantEnd(turn.grant.end_code), self._crowd
        person = next(one for one in crowd.people if one.user.pk == turn.user_id)
        staff, named = crowd.staff, f"the turn {turn.pk} of {person.name} ended as {code.value!r}"
        lasted_s = self.lasted_s.get(turn.pk, 0.0)
        if not turn.end_reason:
            self.wrong.append(f"{named}, without a reason")
        causes = {
            GrantEnd.HOLDER: turn.ticket_id in person.told.gave_up,
            GrantEnd.STAFF: turn.ticket_id in staff.removed,
            GrantEnd.LOCKED_OUT: staff.locked_out,
            GrantEnd.UNFIT: turn.user_id in staff.suspended,
            GrantEnd.TIME_UP: lasted_s >= crowd.turn_s - EARLY_S,
            GrantEnd.ABSENT: self.unheard_s.get(turn.pk, 0.0) >= RULES["RECONNECT_S"] - EARLY_S,
            GrantEnd.IDLE: lasted_s >= RULES["IDLE_S"] - EARLY_S,
        }
        if not causes.get(code, False):
            self.wrong.append(f"{named}, and nothing happened for which it should: {turn.end_reason}")

    def _check_told(self, person) -> None:
        told, name = person.told, person.name
        rows = {ticket.pk: ticket for ticket in Ticket.objects.filter(pk__in=told.tickets)}
        for pk in told.tickets:
            if pk not in rows:
                self.wrong.append(f"the place {pk} of {name} is gone")
            elif rows[pk].state not in OPEN_TICKET:
                self._check_place(person, rows[pk])
        for what, model, keys in (
            ("turn", Turn, told.turns),
            ("command", Command, told.commands),
            ("job", Job, told.jobs),
        ):
            gone = keys - set(model.objects.filter(pk__in=keys).values_list("pk", flat=True))
            self.wrong += [f"the {what} {pk} of {name} is gone" for pk in sorted(gone)]
        texts = dict(Entry.objects.filter(pk__in=told.entries).values_list("pk", "text"))
        if texts != told.entries:
            self.wrong.append(f"the entries of {name} are {texts}, and were {told.entries}")
        answers = set(SurveyResponse.objects.filter(turn__in=told.answers).values_list("turn", flat=True))
        self.wrong += [f"the answers of {name} after the turn {pk} are gone" for pk in sorted(told.answers - answers)]

    def _check_place(self, person, ticket: Ticket) -> None:
        """Let a place have ended only as a turn, by its person, by staff, or by an absence."""
        staff, named = self._crowd.staff, f"the place {ticket.pk} of {person.name} ended: {ticket.end_reason!r}"
        if ticket.state == TicketState.DONE:
            if not Turn.objects.filter(ticket=ticket).exclude(ended_at=None).exists():
                self.wrong.append(f"{named}, after no turn")
            return
        causes = {
            PlaceEnd.LEFT: ticket.pk in person.told.gave_up,
            PlaceEnd.REMOVED: ticket.pk in staff.removed,
            PlaceEnd.SUSPENDED: person.user.pk in staff.suspended,
            PlaceEnd.NO_ANSWER: self.offered_s.get(ticket.pk, 0.0) >= RULES["OFFER_S"] - EARLY_S,
            PlaceEnd.AWAY: person.longest_absence_s >= 900.0 - EARLY_S,
        }
        if not causes.get(ticket.end_reason, False):
            self.wrong.append(f"{named}, and nothing happened for which it should")

    def _check_charge(self, account: Account) -> None:
        """Let an account have been charged for what it used last, once, and for no more than that lasted."""
        turns = Turn.objects.filter(user=account.user).exclude(ended_at=None).select_related("ticket")
        for turn in turns:
            if turn.charged_s > self.lasted_s.get(turn.pk, 0.0) + EARLY_S:
                self.wrong.append(
                    f"the turn {turn.pk} costs {turn.charged_s} s and lasted {self.lasted_s.get(turn.pk)} s"
                )
        tags = [turn.ticket.start_tag + turn.charged_s for turn in turns]
        jobs = Job.objects.filter(account=account, start_tag__isnull=False).exclude(charged=None)
        tags += [job.start_tag + job.charged for job in jobs]
        if account.finish_tag and not any(isclose(account.finish_tag, tag, abs_tol=1e-6) for tag in tags):
            self.wrong.append(
                f"the account of {account.user} stands at {account.finish_tag}, and was charged to {tags}"
            )

    def _check_jobs(self) -> None:
        """Let a job have run to its end at most once, and have ended as its newest command has."""
        done = defaultdict(int)
        for job in Job.objects.all():
            states = list(
                Command.objects.filter(grant__job_run__job=job).order_by("pk").values_list("state", flat=True)
            )
            done[job.pk] = states.count(CommandState.COMPLETED)
            if done[job.pk] > 1:
                self.wrong.append(f"the job {job.pk} ran {done[job.pk]} times to its end")
            if job.state in OPEN_JOB:
                continue
            if (job.state == JobState.DONE) != bool(done[job.pk]):
                self.wrong.append(f"the job {job.pk} is {job.state}, and its commands are {states}")
            if CommandState.UNKNOWN in states[:-1]:
                self.wrong.append(f"the job {job.pk} was begun again after nobody knew how it had ended: {states}")
            if job.state != JobState.DONE and not job.reason:
                self.wrong.append(f"the job {job.pk} ended as {job.state} without a reason")
            if job.state == JobState.CANCELLED and not self._cancelled(job):
                self.wrong.append(f"nobody cancelled the job {job.pk}, and no stop or ban came: {job.reason}")

    def _cancelled(self, job: Job) -> bool:
        person = next(one for one in self._crowd.people if one.user.pk == job.user_id)
        by_somebody = job.pk in person.told.cancelled or job.user_id in self._crowd.staff.suspended
        return by_somebody or self._portal.row.stopped_at is not None
