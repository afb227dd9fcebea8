"""Commands in both lanes, owners, grants and stops in any order, with deaths at every point between (Hypothesis).

Real services, real rows, the owner's real lease, gate, latch, claims and runner; only the
arm is a stand-in that counts, and judges each motion at the moment when it begins.
"""

import os
import shutil
from datetime import timedelta

import pytest
from django.conf import settings
from hypothesis import Phase
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from hypothesis.extra.django import TestCase
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule, run_state_machine_as_test

from accounts.models import User
from robots import services
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import RobotError
from robots.kit.contract.session import Outcome, RobotState
from robots.models import Command, Grant, Lease, Robot
from robots.states import COMMAND_FINAL, Cycle, GrantEnd, GrantKind
from tests.conftest import CALIBRATION, FakeClock
from tests.services.owner import followed
from workers.commands import rows
from workers.process.wiring import Owner

DEATHS = (None, None, None, "before_claim", "after_claim", "before_send", "after_send", "after_ack", "before_finish")
SLOW = "slow"  # alive and still the owner, but long on the way from claim to line


class Killed(BaseException):
    """The process is gone; nothing catches this."""


class Arm:
    """The one arm on the bench; it knows every motion that was ever made."""

    def __init__(self, machine):
        self.machine = machine
        self.motions: list[float] = []

    def act(self, owner, name, value):
        """Move to x, or set the speed beside that."""
        now = self.machine.clock.now()
        open_grants = Grant.objects.filter(ended_at=None, until__gt=now)
        assert open_grants.count() == 1, "a motion without an open grant"
        assert not self.machine.stopped, "a motion after a stop that nobody released"
        lease = Lease.objects.get()
        assert owner.lease.epoch == lease.epoch, "a motion of a stale epoch"
        assert lease.expires_at > now, "a motion of an owner whose lease is over"
        command = Command.objects.get(**{f"args__{name}": value})
        assert command.deadline > now, "a late motion"
        assert command.grant_id == open_grants.get().pk, "a motion under somebody else's grant"
        assert value not in self.motions, "a command was carried out twice"
        self.motions.append(value)


class Wire:
    """The driver of one owner: asks the permit last, then moves the arm."""

    clock = SYSTEM  # by which its state is old

    def __init__(self, arm):
        self.arm, self.owner, self.dies, self.beside = arm, None, None, False

    def latest(self):
        return RobotState(0.0, (0, 0, 0, 0), (0, 0.4, 0.075, 0), False, True)

    state = connect = hold = latest

    def close(self):
        return None

    def check(self, kind, args, pose=None):
        return None

    def _point(self, label):
        if self.dies == label:
            raise Killed

    def execute(self, kind, args, permit, on_stage):
        self._point("before_send")
        if self.dies == SLOW:
            self.arm.machine.time(11, renewed=True)
        permit()
        name = "speed" if kind == "speed" else "x"
        self.arm.act(self.owner, name, args[name])
        self._point("after_send")
        on_stage("sent")
        on_stage("acknowledged")
        if self.beside and kind != "speed":  # as the other lane's thread does
            self.arm.machine._work(self.owner, self.dies, self.owner.config)
            assert self.owner.lane.current is not None, "a command beside ended the motion"
        self._point("after_ack")
        return Outcome({}, self.latest())


class MotionMachine(RuleBasedStateMachine):
    def __init__(self):
        super().__init__()
        for model in (Command, Grant, Lease, Robot, User):
            model.objects.all().delete()
        shutil.rmtree(settings.VAR / "run", ignore_errors=True)
        self.clock = FakeClock()
        self.robot = Robot.objects.create(
            slug="mercury",
            name="M",
            address="sim:mercury",
            enabled=True,
            cycle=Cycle.OPERATING,
            calibration=CALIBRATION,
        )
        self.ada = User.objects.create_user("ada", "ada@example.org")
        self.kim = User.objects.create_superuser("kim", "kim@example.org")
        self.arm = Arm(self)
        self.owners: list[Owner] = []
        self.seq = self.asked = 0
        self.stopped = False
        self.told: list[int] = []

    @rule()
    def start_worker(self):
        owner = Owner("mercury", self.clock, on_lost=lambda: None)
        owner.lease.measure_offset = lambda: None
        owner.owned.driver = Wire(self.arm)
        owner.owned.driver.owner = owner
        Lease.objects.get_or_create(robot=self.robot)
        if owner.lease._try():
            owner.owned.running = True
            owner.link.note_answer()
            rows.abandon(owner.owned.robot, owner.owned.now())
            self.owners.append(owner)
        else:
            self._bury(owner)

    def _bury(self, owner):
        owner.pictures.close()  # the camera may be there: of a simulator that runs on from another test
        if owner.lease._descriptor is not None:
            os.close(owner.lease._descriptor)
            owner.lease._descriptor = None
        if owner in self.owners:
            self.owners.remove(owner)

    def _one(self, index):
        return self.owners[index % len(self.owners)]

    @rule(seconds=st.sampled_from([0.1, 0.5, 1, 2.9, 3.1, 11, 100, -2]), renewed=st.booleans())
    def time(self, seconds, renewed):
        for _ in range(int(seconds) if renewed else 0):
            self.clock.go(1.0)
            for owner in self.owners:
                owner.lease.renew()
        if not renewed or seconds < 1:
            self.clock.go(seconds)
        for owner in self.owners:
            owner.link.note_answer()

    @precondition(lambda self: self.owners)
    @rule(index=st.integers(0, 3))
    def renew(self, index):
        self._one(index).lease.renew()

    @precondition(lambda self: self.owners)
    @rule(index=st.integers(0, 3))
    def the_device_lock_is_taken_away(self, index):
        (settings.VAR / "run" / "mercury.lock").unlink(missing_ok=True)

    @rule(seconds=st.sampled_from([5, 60]))
    def open_grant(self, seconds):
        try:
            services.start_grant(
                self.robot, GrantKind.TURN, self.clock.now(), self.ada, self.clock.now() + timedelta(seconds=seconds)
            )
        except RobotError as error:
            assert str(error).endswith(".")

    @rule()
    def end_grant(self):
        grant = services.open_grant(self.robot)
        if grant:
            services.end_grant(grant, GrantEnd.STAFF, "test", self.clock.now())

    def _make_ready(self):
        """Create an owner and a grant, without a stop, as for an operator who presses a button."""
        if self.stopped:
            self.lift()
            self.release(True)
        if not any(o.lease.valid for o in self.owners):
            for owner in list(self.owners):
                self._bury(owner)
            self.clock.go(3.1)
            self.start_worker()
        grant = services.open_grant(self.robot)
        if grant and grant.until <= self.clock.now():
            self.end_grant()
        self.open_grant(60)

    @rule(
        again=st.booleans(), ready=st.booleans(), wakes=st.integers(0, 3), dies=st.sampled_from((*DEATHS, SLOW)),
        beside=st.booleans(), between=st.sampled_from(["", "", "late", "lapse", "stop", "end"]),
    )  # fmt: skip
    def issue(self, again, ready, wakes, dies, beside, between):
        if ready:
            self._make_ready()
        self.seq += 0 if again and self.seq else 1
        self.asked += 1
        try:
            issued = services.issue(
                "mercury", self.ada, "move", {"x": self.asked * 1e-5, "y": 0.4}, self.seq, self.clock.now()
            )
        except RobotError as error:
            assert str(error).endswith(".")
            return
        self.told.append(issued.command.pk)
        if beside:
            self.configure()
        match between:
            case "late":
                self.time(11, renewed=True)
            case "lapse":
                self.time(3.1, renewed=False)
            case "stop" if self.owners:
                self.stop_that_only_the_owner_hears(len(self.owners) - 1)
            case "end":
                self.end_grant()
        if wakes and self.owners:
            self.wake(len(self.owners) - 1, dies, wakes, beside)
        if wakes > 1 and self.owners:
            self.deliver_again_and_late(len(self.owners) - 1, len(self.told) - 1)

    @rule(
        again=st.booleans(), wakes=st.integers(1, 3), dies=st.sampled_from((None, SLOW, *DEATHS)), beside=st.booleans(),
        between=st.sampled_from(["", "", "late", "lapse", "stop", "end"]),
    )  # fmt: skip
    def press(self, again, wakes, dies, beside, between):
        """Issue where it may be carried out: among all rules this would come too rarely to prove much."""
        self.issue(again, True, wakes, dies, beside, between)

    @precondition(lambda self: self.owners)
    @rule(index=st.integers(0, 3), dies=st.sampled_from((*DEATHS, SLOW)), times=st.integers(1, 3), beside=st.booleans())
    def wake(self, index, dies, times, beside):
        owner = self._one(index)
        owner.owned.driver.dies, owner.owned.driver.beside = dies, beside
        try:
            for _ in range(times):
                self._work(owner, dies, owner.motion)
                self._work(owner, dies, owner.config)
        except Killed:
            self._bury(owner)

    def _work(self, owner, dies, commands):
        due = rows.due(owner.owned.robot, owner.lease.epoch, commands.lane.name)
        for command in due.select_related("grant"):
            if dies == "before_claim":
                raise Killed
            command.robot = owner.owned.robot
            if not rows.claim(command, owner.lease.epoch, owner.owned.now()):
                continue
            if dies == "after_claim":
                raise Killed
            if dies == "before_finish":
                commands._run.__self__._end = lambda *a: (_ for _ in ()).throw(Killed())
            commands._run(command)

    @rule()
    def configure(self):
        """Staff change the speed, whoever has the robot."""
        self.asked += 1
        try:
            speed = {"speed": 0.05 + self.asked * 1e-6}
            command = services.configure(self.robot, self.kim, "speed", speed, self.clock.now())
        except RobotError as error:
            assert str(error).endswith(".")
        else:
            self.told.append(command.pk)

    @precondition(lambda self: self.owners and self.told)
    @rule(index=st.integers(0, 3), which=st.integers(0, 999))
    def deliver_again_and_late(self, index, which):
        """A wake-up names no command, but a frozen worker may hold one that it read before."""
        owner = self._one(index)
        owner.owned.driver.dies = None
        command = Command.objects.select_related("grant").get(pk=self.told[which % len(self.told)])
        command.robot = owner.owned.robot
        if rows.claim(command, owner.lease.epoch, owner.owned.now()):
            (owner.config if command.lane == "config" else owner.motion)._run(command)

    @precondition(lambda self: self.owners)
    @rule(index=st.integers(0, 3))
    def sweep(self, index):
        owner = self._one(index)
        if owner.lease.valid:
            owner.motion.tidy()
            owner.config.tidy()

    @precondition(lambda self: self.owners)
    @rule(index=st.integers(0, 3))
    def follow(self, index):
        self._one(index).stopping.follow()
        self._one(index).follower.follow_grant()

    @rule()
    def stop(self):
        services.stop(self.robot, self.kim, self.clock.now())
        self.stopped = True

    @precondition(lambda self: self.owners)
    @rule(index=st.integers(0, 3))
    def stop_that_only_the_owner_hears(self, index):
        owner = self._one(index)
        owner.stopping.halt("bus")
        if owner.lease.valid and not self.stopped:
            self.stopped = True
            followed(owner)  # the row follows within a tenth of a second

    @rule(checked=st.booleans())
    def release(self, checked):
        try:
            services.release_stop(self.robot, self.kim, checked)
        except RobotError:
            assert not checked
            return
        self.stopped = False
        for owner in self.owners:
            followed(owner)

    @rule()
    def lock_out(self):
        services.lock_out(self.robot, self.kim, "test")
        self.stopped = True

    @rule()
    def lift(self):
        Robot.objects.filter(pk=self.robot.pk, cycle=Cycle.LOCKED_OUT).exists() and services.lift_lock_out(
            self.robot, self.kim
        )
        self.stopped = Robot.objects.get().stop_latched
        for owner in self.owners:
            followed(owner)

    @invariant()
    def at_most_one_open_grant(self):
        assert Grant.objects.filter(ended_at=None).count() <= 1

    @invariant()
    def at_most_one_owner(self):
        assert sum(o.lease.valid and o.lease.epoch == Lease.objects.get().epoch for o in self.owners) <= 1

    @invariant()
    def nothing_told_is_lost(self):
        assert Command.objects.filter(pk__in=self.told).count() == len(set(self.told))

    @invariant()
    def every_end_has_a_reason(self):
        ended = Command.objects.filter(state__in=COMMAND_FINAL).exclude(state="completed")
        assert not ended.filter(reason="").exists()

    def teardown(self):
        """Let a new owner end everything, whatever happened."""
        for owner in list(self.owners):
            self._bury(owner)
        self.clock.go(30)
        self.start_worker()
        if self.owners:
            self.owners[0].motion.tidy()
            self.owners[0].config.tidy()
            assert not Command.objects.exclude(state__in=COMMAND_FINAL).exists(), "a command never ends"
            self._bury(self.owners[0])


@pytest.mark.service
class TestMotion(TestCase):
    def test_promise_08_anything_in_any_order(self):
        from tests.proof import AT_LENGTH, FULL, Proof

        small = 40 if "FARHAND_MUTANT" in os.environ else 20 if AT_LENGTH else 8
        examples = 400 if FULL else small
        run_state_machine_as_test(
            MotionMachine,
            settings=hypothesis_settings(
                max_examples=examples,
                stateful_step_count=80,
                deadline=None,
                derandomize=not FULL,
                phases=(Phase.generate,) if "FARHAND_MUTANT" in os.environ else tuple(Phase),
            ),
        )
        for promise in (1, 2, 3, 4, 8):
            proof = Proof("test_motion_machine.py::test_promise_08_anything_in_any_order", promise)
            proof.count("orders of up to 80 steps", small, 400)
            proof.holds("commands, owners, grants, stops and deaths in any order: 0 violations")
