"""Everything in any order: at most one operator, one grant, nothing lost (Hypothesis)."""

from datetime import timedelta

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.extra.django import TestCase
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule, run_state_machine_as_test

from accounts.models import Clearance, User
from queueing import services as queue
from queueing.errors import NotCleared, QueueError
from queueing.models import OPEN_JOB, OPEN_TICKET, Account, Job, QueueRobot, Ticket, TicketState, Turn
from queueing.services import Asker, ask, cancel
from robots.grants import end_grant
from robots.kit.contract.spec import ANYONE, CommandKind
from robots.models import Command, Grant, Lease, Robot
from robots.states import CommandState, Cycle, GrantEnd
from tests.conftest import CALIBRATION, FakeClock
from workers.commands import rows

NAMES = ("ada", "bob", "cyd", "dan")
who = st.sampled_from(NAMES)


class QueueMachine(RuleBasedStateMachine):
    def __init__(self):
        super().__init__()
        for model in (Job, Turn, Ticket, Account, Grant, Robot, User):
            model.objects.all().delete()
        self.clock = FakeClock()
        self.robot = Robot.objects.create(
            slug="mercury", name="M", address="sim:mercury", enabled=True, cycle=Cycle.READY, calibration=CALIBRATION
        )
        Lease.objects.create(robot=self.robot, epoch=1, expires_at=self.clock.now() + timedelta(days=9))
        self.people = {n: User.objects.create_user(n, f"{n}@example.org") for n in NAMES}
        for person in self.people.values():
            Clearance.objects.create(user=person, robot=self.robot, granted_at=self.clock.now())
        self.told: dict[str, int] = {}
        queue.queue_of(self.robot)
        QueueRobot.objects.update(guests_ask=True)

    @rule(name=who, classic=st.booleans())
    def join(self, name, classic):
        person = User.objects.get(username=name)
        try:
            self.told[name] = queue.join(self.robot, person, self.clock.now(), classic).pk
        except NotCleared:
            assert not self.allowed(name)

    def allowed(self, name):
        person = self.people[name]
        cleared = Clearance.objects.filter(user=person, revoked_at=None).exists()
        return cleared and User.objects.get(pk=person.pk).is_active

    @rule(name=who, active=st.booleans())
    def ban_or_pardon(self, name, active):
        User.objects.filter(username=name).update(is_active=active)

    @rule(name=who, withdrawn=st.booleans())
    def clearance_changes(self, name, withdrawn):
        Clearance.objects.filter(user=self.people[name]).update(revoked_at=self.clock.now() if withdrawn else None)

    @rule(name=who)
    def leave(self, name):
        queue.leave(self.robot, self.people[name], self.clock.now())
        self.told.pop(name, None)

    @rule(name=who)
    def accept(self, name):
        had = Turn.objects.filter(ended_at=None, user=self.people[name]).exists()
        try:
            queue.accept(self.robot, self.people[name], self.clock.now())
            assert had or self.allowed(name)
        except QueueError as error:
            assert str(error).endswith(".")

    def asker(self, name, guest):
        return Asker(guest=name * 8, network=f"192.0.2.{len(name) % 2}") if guest else Asker(user=self.people[name])

    @rule(name=who, guest=st.booleans())
    def ask_for_a_job(self, name, guest):
        try:
            ask(self.robot, self.asker(name, guest), "down", {}, self.clock.now())
        except QueueError as error:
            assert str(error).endswith(".")

    @rule(name=who, guest=st.booleans())
    def cancel_a_job(self, name, guest):
        asker = self.asker(name, guest)
        for job in Job.objects.filter(state__in=OPEN_JOB, user=asker.user, guest=asker.guest)[:1]:
            cancel(job, asker, self.clock.now())

    @rule(state=st.sampled_from(["completed", "completed", "failed", "expired", "cancelled", "unknown"]))
    def owner_ends_what_runs(self, state):
        for command in Command.objects.select_related("robot", "grant").filter(ended_at=None):
            rows.finish(command, CommandState(state), self.clock.now(), "So it ended.")

    @rule(seconds=st.sampled_from([0, 1, 5, 21, 31, 61, 100, 301, 1000, -3]))
    def time(self, seconds):
        self.clock.go(seconds)

    @rule()
    def tick(self):
        queue.tick(self.clock.now())
        queue.tick(self.clock.now())
        for ticket in Ticket.objects.filter(state__in=OPEN_TICKET):
            assert self.allowed(ticket.user.username), "a tick takes out who may no longer drive"

    @rule(name=who)
    def seen(self, name):
        queue.note_presence(self.robot, self.people[name], self.clock.now())

    @rule(name=who)
    def line_cut(self, name):
        queue.note_disconnection(self.robot, self.people[name], self.clock.now())

    @rule()
    def owner_hands_over(self):
        Robot.objects.filter(cycle=Cycle.HANDOVER).update(cycle=Cycle.READY)

    @rule(cycle=st.sampled_from([Cycle.FAULT, Cycle.HANDOVER]))
    def robot_changes(self, cycle):
        Robot.objects.filter(cycle__in=(Cycle.READY, Cycle.OFFERED, Cycle.FAULT)).update(cycle=cycle)

    @rule()
    def owner_ends_overdue_grants(self):
        for grant in Grant.objects.filter(ended_at=None):
            if grant.until is not None and grant.until <= self.clock.now():
                end_grant(grant, GrantEnd.TIME_UP, "time is up", self.clock.now())

    @invariant()
    def one_operator_one_grant(self):
        assert Turn.objects.filter(ended_at=None).count() <= 1
        assert Grant.objects.filter(ended_at=None).count() <= 1
        for turn in Turn.objects.filter(ended_at=None):
            assert turn.ticket.state == TicketState.OPERATING
        for ticket in Ticket.objects.filter(state=TicketState.OPERATING):
            assert ticket.turn.ended_at is None

    @invariant()
    def a_place_that_was_told_exists_or_has_a_reason(self):
        for name, pk in self.told.items():
            ticket = Ticket.objects.get(pk=pk)
            assert ticket.user == self.people[name]
            assert ticket.state in OPEN_TICKET or ticket.end_reason

    @invariant()
    def every_ended_turn_has_a_reason_and_a_charge(self):
        for turn in Turn.objects.exclude(ended_at=None):
            assert turn.end_reason
            assert turn.charged_s is not None
            assert turn.charged_s >= 0

    @invariant()
    def a_job_runs_under_a_grant_of_its_own_and_no_job_is_lost(self):
        for job in Job.objects.exclude(state="waiting"):
            assert job.runs.exists() or job.state == "cancelled"
            assert job.state == "running" or (job.ended_at and job.charged is not None and job.charged >= 0)
        for grant in Grant.objects.filter(kind="job"):
            assert grant.job_run
            assert grant.commands.count() == 1
        assert not (Ticket.objects.filter(state="offered").exists() and Grant.objects.filter(ended_at=None, kind="job"))

    @invariant()
    def of_each_account_one_request_has_a_tag(self):
        for account in Account.objects.all():
            tagged = Job.objects.filter(account=account, state="waiting", start_tag__isnull=False).count()
            tickets = Ticket.objects.filter(user=account.user, state__in=OPEN_TICKET).count() if account.user else 0
            assert tagged + tickets <= 1

    @invariant()
    def at_most_one_offer(self):
        assert Ticket.objects.filter(state=TicketState.OFFERED).count() <= 1


@pytest.mark.service
class TestQueue(TestCase):
    def setUp(self):
        kinds = (CommandKind("down", "Down", asked_by=frozenset({ANYONE})),)
        patch = pytest.MonkeyPatch()
        patch.setattr("queueing.jobs.asking.job_kinds", lambda robot: kinds)
        self.addCleanup(patch.undo)

    def test_promise_13_anything_in_any_order(self):
        from tests.proof import AT_LENGTH, FULL, Proof

        examples = 100 if FULL else 12 if AT_LENGTH else 5
        run_state_machine_as_test(
            QueueMachine,
            settings=settings(
                max_examples=examples,
                stateful_step_count=40,
                deadline=None,
                derandomize=not FULL,
            ),
        )
        proof = Proof("test_queue_machine.py::test_promise_13_anything_in_any_order", 13)
        proof.count("orders of up to 40 steps", 12, 100, 400)
        proof.holds("joined, offered, accepted, dropped, returned, banned, in any order: never two operators")
