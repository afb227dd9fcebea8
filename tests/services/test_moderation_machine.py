"""Edits, decisions, undo and appeals in any order, also from old pages and by a clock that is set (Hypothesis)."""

import pytest
from django.contrib.auth.models import Permission
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.extra.django import TestCase
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule, run_state_machine_as_test

from accounts.models import User
from operatorlog import services as log
from operatorlog.models import Appeal, Decision, Entry, Visibility
from queueing.models import Turn
from robots.models import Grant, Robot
from tests.conftest import FakeClock

MODERATORS = ("mod", "mia")
FIELDS = ("visibility", "hidden_reason", "hidden_words", "moderated_by", "moderated_at", "waits")
moderator = st.sampled_from(MODERATORS)
texts = st.sampled_from(("one", "two", "three"))


class ModerationMachine(RuleBasedStateMachine):
    """One entry; `read` is the revision of the page that each moderator has open."""

    def __init__(self):
        super().__init__()
        for model in (Decision, Appeal, Entry, Turn, Grant, Robot, User):
            model.objects.all().delete()
        self.clock = FakeClock()
        robot = Robot.objects.create(slug="mercury", name="M", address="sim:mercury", enabled=True)
        self.people = {name: User.objects.create_user(name, f"{name}@example.org") for name in ("ada", *MODERATORS)}
        may = Permission.objects.get(codename="change_entry")
        for name in MODERATORS:
            self.people[name].user_permissions.add(may)
        now = self.clock.now()
        grant = Grant.objects.create(robot=robot, kind="turn", holder=self.people["ada"], opened_at=now, ended_at=now)
        turn = Turn.objects.create(
            robot=robot,
            user=self.people["ada"],
            grant=grant,
            started_at=now,
            base_until=now,
            until=now,
            last_seen=now,
            ended_at=now,
        )
        self.key = log.write(turn, self.people["ada"], "one", None, now).pk
        self.read = dict.fromkeys(MODERATORS, 0)
        self.waits = True  # what a moderator has to look at
        self.undoable: tuple[int, dict[str, object], bool] | None = None  # decision, state before it, whether it waited

    def entry(self):
        return Entry.objects.get(pk=self.key)

    def state(self):
        return Entry.objects.filter(pk=self.key).values(*FIELDS).get()

    @rule(seconds=st.sampled_from([0, 1, 60]), step=st.sampled_from([0, 0, 600, -3600]))
    def time(self, seconds, step):
        self.clock.go(seconds)
        self.clock.step(step)

    @rule(text=texts)
    def edit(self, text):
        before = self.entry()
        try:
            after = log.edit(before, self.people["ada"], text, None, self.clock.now())
        except log.LogError:
            return
        if before.text != text:
            assert after.visibility != Visibility.FEATURED
            self.waits, self.undoable = True, None

    @rule(name=moderator)
    def open(self, name):
        self.read[name] = self.entry().revision

    @rule(
        name=moderator, fresh=st.booleans(), wanted=st.sampled_from(Visibility), reason=st.sampled_from(["rude", ""])
    )  # fmt: skip
    def decide(self, name, fresh, wanted, reason):
        if fresh:
            self.open(name)
        before, state, made = self.entry(), self.state(), Decision.objects.count()
        try:
            decision = log.moderate(
                self.entry(), self.people[name], wanted, reason, self.clock.now(), "", self.read[name]
            )
        except log.Outdated:
            assert self.read[name] != before.revision
            assert self.state() == state
        except log.LogError:
            assert (wanted, reason) == (Visibility.HIDDEN, "")
            assert self.state() == state
        else:
            assert self.entry().visibility == wanted
            if Decision.objects.count() == made:
                assert self.state() == state, "a double press"
                return
            assert self.read[name] == before.revision, "nobody decides on what they have not read"
            self.undoable, self.waits = (decision.pk, state, self.waits), False

    @rule(own=st.sampled_from([True, True, False]), back=st.sampled_from([0, 0, 0, 1, 2]))
    def undo(self, own, back):
        decision, before = Decision.objects.order_by("-pk")[back : back + 1].first(), self.state()
        if decision is None:
            return
        name = decision.by.username if own else next(one for one in MODERATORS if one != decision.by.username)
        undone = decision.undone_at is not None
        try:
            done = log.undo(decision, self.people[name], self.clock.now())
        except log.LogError:
            assert self.state() == before
            assert decision.by.username != name or self.undoable is None or self.undoable[0] != decision.pk
            return
        assert decision.by.username == name
        assert done == (not undone)
        if not done:
            assert self.state() == before
            return
        assert self.undoable is not None and self.undoable[0] == decision.pk
        assert self.state() == self.undoable[1]
        self.waits, self.undoable = self.undoable[2], None

    @rule(words=st.sampled_from(["please", "again"]))
    def appeal(self, words):
        entry, open_before = self.entry(), Appeal.objects.filter(answer=None).first()
        may = log.may_appeal(entry, self.people["ada"])
        try:
            made = log.appeal(entry, self.people["ada"], words, self.clock.now())
        except log.LogError:
            assert not may
            return
        if made == open_before:
            return  # a double press
        assert may
        assert entry.visibility == Visibility.HIDDEN
        self.waits, self.undoable = True, None

    @invariant()
    def the_queue_has_it_if_and_only_if_a_moderator_has_to_look(self):
        assert log.to_review().exists() == self.waits

    @invariant()
    def an_open_appeal_is_one_and_waits(self):
        assert Appeal.objects.filter(answer=None).count() <= int(self.waits)

    @invariant()
    def the_same_text_is_appealed_against_once(self):
        read = [(one.answer.text, one.answer.picture) for one in Appeal.objects.exclude(answer=None)]
        entry = self.entry()
        if (entry.text, "") in read[-1:] and not Appeal.objects.filter(answer=None).exists():
            assert not log.may_appeal(entry, self.people["ada"])

    @invariant()
    def what_is_hidden_has_a_reason_and_nothing_else_has(self):
        entry = self.entry()
        assert (entry.visibility == Visibility.HIDDEN) == bool(entry.why_hidden)


@pytest.mark.service
class TestModeration(TestCase):
    def test_any_order_of_edits_decisions_undo_and_appeals(self):
        run_state_machine_as_test(
            ModerationMachine, settings=settings(max_examples=40, stateful_step_count=25, deadline=None)
        )
