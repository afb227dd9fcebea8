"""Two lanes: a command that changes a setting runs beside a motion, and through the same gate."""

import threading
from dataclasses import replace
from datetime import timedelta

import pytest

from robots import services
from robots.kit.contract.errors import BadRequest, HardwareFault, NotPermitted, Stopped
from robots.kit.contract.session import Outcome
from robots.models import Command, Grant, Robot
from robots.states import Cycle, GrantKind
from tests.services.owner import Arm, begun, followed, made_owner
from tests.waiting import CEILING_S, wait_for
from workers.commands import rows

pytestmark = [
    pytest.mark.service, pytest.mark.django_db(transaction=True), pytest.mark.usefixtures("installed"),
    pytest.mark.parametrize("which", ["turntable"], indirect=True),
]  # fmt: skip


class Table(Arm):
    """Its motion goes on until it is released or held; a setting does what the test says."""

    def __init__(self):
        super().__init__()
        self.holds, self.resets, self.pace, self.setting = 0, 0, 1.0, lambda: None
        self.shows = lambda: self.pace
        self.moving, self.rest, self.order = threading.Event(), threading.Event(), []

    def latest(self):
        return replace(super().latest(), values={"pace": self.shows()})

    state = latest

    def connect(self):
        return self.latest()

    def close(self):
        pass

    def hold(self):
        self.rest.set()
        return super().hold()

    def recover(self, permit):
        self.resets += 1
        return self.latest()

    def execute(self, kind, args, permit, on_stage):
        permit()
        on_stage("sent")
        if kind == "pace":
            self.setting()
            permit()
            self.pace = args["pace"]
        on_stage("acknowledged")
        if kind == "turn":
            self.moving.set()
            assert self.rest.wait(CEILING_S)
            permit()
        self.order.append(kind)
        return Outcome({}, self.latest())


@pytest.fixture
def owner(robot, people):
    made = made_owner(robot, people)
    made.owned.driver = Table()
    return made


@pytest.fixture
def issue(owner, people):
    numbers = iter(range(1, 99))

    def made(kind, **args):
        return services.issue(
            owner.owned.robot.slug, people["ada"], kind, args, next(numbers), owner.owned.now()
        ).command

    return made


@pytest.fixture
def turning(owner, issue):
    """A motion that runs in a thread of its own; yields its row, ends when the table rests."""
    command = issue("turn", angle=1.0)
    thread = begun(owner.motion.run_due)
    assert owner.owned.driver.moving.wait(CEILING_S)
    yield command
    owner.owned.driver.rest.set()
    thread.join(CEILING_S)


def state_of(command):
    command.refresh_from_db()
    return command.state


def until(command, state):
    wait_for(lambda: state_of(command) == state, CEILING_S, f"{command} is {state}")


def test_a_setting_completes_while_a_motion_runs(owner, issue, turning):
    setting = issue("pace", pace=0.5)
    assert setting.lane == "config"
    owner.config.run_due()
    assert (state_of(setting), state_of(turning), owner.owned.driver.pace) == ("completed", "acknowledged", 0.5)
    assert owner.lane.current == turning
    owner.owned.driver.rest.set()
    until(turning, "completed")
    assert owner.owned.driver.order == ["pace", "turn"]


def test_a_motion_waits_for_a_motion_and_not_for_a_setting(owner, issue, turning):
    waiting = issue("turn", angle=0.0)
    owner.config.run_due()
    assert state_of(waiting) == "queued"


def test_a_stop_during_both_ends_both_and_refuses_more(owner, issue, people, turning):
    setting_begun, go_on = threading.Event(), threading.Event()
    owner.owned.driver.setting = lambda: (setting_begun.set(), go_on.wait(CEILING_S))
    setting, later = issue("pace", pace=0.5), issue("pace", pace=0.7)
    thread = begun(owner.config.run_due)
    assert setting_begun.wait(CEILING_S)
    owner.stopping.halt("test")  # with a setting on its way: no lock of its own keeps the hold waiting
    assert owner.owned.driver.holds == 1
    go_on.set()
    thread.join(CEILING_S)
    until(turning, "cancelled")
    assert (state_of(setting), state_of(later), owner.owned.driver.pace) == ("cancelled", "rejected", 1.0)
    Robot.objects.update(stop_latched=True)
    with pytest.raises(Stopped):
        issue("pace", pace=0.5)
    with pytest.raises(Stopped):
        services.configure(owner.owned.robot, people["kim"], "pace", {"pace": 0.5}, owner.owned.now())
    owner.latch.release()


def test_a_crash_with_both_running_ends_both_unknown(owner, issue):
    both = [issue("turn", angle=1.0), issue("pace", pace=0.5)]
    for command in both:
        assert rows.claim(command, owner.lease.epoch, owner.owned.now())
    assert rows.abandon(owner.owned.robot, owner.owned.now()) != []
    assert [state_of(c) for c in both] == ["unknown", "unknown"]


def test_the_grant_of_an_earlier_setting_holds_no_later_motion(owner, issue, people):
    setting = issue("pace", pace=0.5)
    owner.config.run_due()
    assert state_of(setting) == "completed"
    services.end_grant(services.open_grant(owner.owned.robot), "holder", "test", owner.owned.now())
    owner.grants.revoke(setting.grant_id)
    services.start_grant(
        owner.owned.robot, GrantKind.TURN, owner.owned.now(), people["ada"], owner.owned.now() + timedelta(seconds=60)
    )
    command = issue("turn", angle=1.0)
    thread = begun(owner.motion.run_due)
    assert owner.owned.driver.moving.wait(CEILING_S)
    for lane in owner.lanes:
        owner.watch._hold_what_is_forbidden(lane)
    assert (len(owner.lanes), owner.owned.driver.holds) == (2, 0)
    owner.owned.driver.rest.set()
    thread.join(CEILING_S)
    assert state_of(command) == "completed"


def test_a_setting_under_a_grant_that_ended_is_refused(owner, issue):
    setting = issue("pace", pace=0.5)
    Grant.objects.filter(pk=setting.grant_id).update(ended_at=owner.owned.now())
    owner.config.run_due()
    assert (state_of(setting), owner.owned.driver.pace) == ("rejected", 1.0)


def test_a_setting_that_fails_resets_no_controller_beside_a_motion(owner, issue, turning):
    def fail():
        raise HardwareFault("The table did not take it.")

    owner.owned.driver.setting = fail
    setting = issue("pace", pace=0.5)
    owner.connection.connected = True
    with owner.lane.taking(20.0):
        owner.config.run_due()
    assert (state_of(setting), owner.owned.driver.resets, owner.connection.connected) == ("failed", 0, True)
    assert state_of(turning) == "acknowledged"


class TestStaff:
    def configure(self, owner, people, pace):
        return services.configure(owner.owned.robot, people["kim"], "pace", {"pace": pace}, owner.owned.now())

    def test_staff_set_it_in_somebodys_turn_without_taking_the_numbers_of_their_controls(self, owner, issue, people):
        first = self.configure(owner, people, 0.4)
        second = self.configure(owner, people, 0.5)
        mine = issue("pace", pace=0.6)
        assert (first.client_seq, second.client_seq, mine.client_seq) == (-1, -2, 1)
        owner.config.run_due()
        assert [state_of(c) for c in (first, second, mine)] == ["completed"] * 3
        assert services.open_grant(owner.owned.robot).pk == mine.grant_id

    def test_where_nobody_has_the_robot_its_grant_ends_with_it_and_nothing_is_put_in_order(self, owner, people):
        services.end_grant(services.open_grant(owner.owned.robot), "holder", "test", owner.owned.now())
        Robot.objects.update(cycle=Cycle.READY)
        command = self.configure(owner, people, 0.4)
        with pytest.raises(NotPermitted, match="A command of staff runs"):
            self.configure(owner, people, 0.5)
        owner.config.run_due()
        assert state_of(command) == "completed"
        assert (services.open_grant(owner.owned.robot), Robot.objects.get().cycle) == (None, "ready")

    def test_others_and_motions_are_refused(self, owner, people):
        for user in ("ada", "eve", "mod"):
            with pytest.raises(NotPermitted):
                services.configure(owner.owned.robot, people[user], "pace", {"pace": 0.5}, owner.owned.now())
        for kind, args in (("turn", {"angle": 1.0}), ("nothing", {}), ("pace", {"pace": 9.0}), ("pace", {})):
            with pytest.raises(BadRequest):
                services.configure(owner.owned.robot, people["kim"], kind, args, owner.owned.now())
        assert not Command.objects.exists()


class TestRestoring:
    def hand_over(self, owner):
        services.end_grant(services.open_grant(owner.owned.robot), "holder", "test", owner.owned.now())
        Robot.objects.update(cycle=Cycle.HANDOVER)
        owner.owned.refresh()
        owner.owned.driver.rest.set()
        with owner.lane.taking(180.0):  # as the control loop does
            owner.control._handover.hand_over()
        return Robot.objects.get().cycle

    def test_what_an_operator_changed_is_set_back_and_confirmed(self, owner, issue):
        issue("pace", pace=0.5)
        owner.config.run_due()
        assert self.hand_over(owner) == "ready"
        row = Command.objects.filter(kind="pace").first()
        assert (row.grant.kind, row.state, row.args, owner.owned.driver.pace) == (
            "handover", "completed", {"pace": 1.0}, 1.0,
        )  # fmt: skip
        assert services.settings_to_reset(owner.owned.robot, owner.owned.robot.spec().commands) == []

    def test_what_nobody_changed_is_left_alone(self, owner):
        assert self.hand_over(owner) == "ready"
        assert not Command.objects.exists()

    def test_what_staff_set_persists_and_is_what_is_set_back_to(self, owner, issue, people):
        services.configure(owner.owned.robot, people["kim"], "pace", {"pace": 0.4}, owner.owned.now())
        owner.config.run_due()
        assert services.settings_to_reset(owner.owned.robot, owner.owned.robot.spec().commands) == []
        issue("pace", pace=1.5)
        owner.config.run_due()
        assert self.hand_over(owner) == "ready"
        assert owner.owned.driver.pace == 0.4

    def test_what_is_not_known_to_have_been_set_is_set_back_too(self, owner, issue):
        command = issue("pace", pace=0.5)
        assert rows.claim(command, owner.lease.epoch, owner.owned.now())
        rows.abandon(owner.owned.robot, owner.owned.now())
        assert self.hand_over(owner) == "ready"
        assert Command.objects.filter(kind="pace").first().args == {"pace": 1.0}

    def test_a_robot_whose_settings_cannot_be_set_back_is_offered_to_nobody(self, owner, issue):
        def fail():
            raise HardwareFault("The table did not take it.")

        issue("pace", pace=0.5)
        owner.config.run_due()
        owner.owned.driver.setting = fail
        assert self.hand_over(owner) == "fault"
        assert "pace could not be set back" in Robot.objects.get().reason
        owner.owned.driver.setting = lambda: None
        Robot.objects.update(cycle=Cycle.HANDOVER)
        owner.owned.refresh()
        with owner.lane.taking(180.0):  # as the control loop does
            owner.control._handover.hand_over()
        assert (Robot.objects.get().cycle, owner.owned.driver.pace) == ("ready", 1.0)

    def test_what_the_robot_does_not_show_is_not_taken_for_set_back(self, owner, issue):
        issue("pace", pace=0.5)
        owner.config.run_due()
        owner.owned.driver.shows = lambda: 0.5  # it acknowledges, and goes on as before
        assert self.hand_over(owner) == "fault"
        assert "shows 0.5" in Robot.objects.get().reason

    def test_what_the_robot_shows_a_moment_later_is_confirmed(self, owner, issue):
        issue("pace", pace=0.5)
        owner.config.run_due()
        later = iter([0.5, 0.6, 0.8])
        owner.owned.driver.shows = lambda: next(later, 1.0)
        assert self.hand_over(owner) == "ready"
        assert next(later, None) is None


class TestRestoringAfterAStop:
    """Under a latched stop nothing is set back, so it is done at the release, before anything moves."""

    hand_over = TestRestoring.hand_over

    @pytest.fixture
    def stopped(self, owner, issue, people):
        """A turn ended under a stop, with a setting of its own; the robot was handed over."""
        issue("pace", pace=0.5)
        owner.config.run_due()
        services.stop(owner.owned.robot, people["ada"], owner.owned.now())
        followed(owner)
        owner.connection.connected = True
        assert self.hand_over(owner) == "ready"
        owner.owned.refresh()
        assert (owner.latch.latched, owner.owned.driver.pace) == (True, 0.5)
        owner.owned.driver.order.clear()
        yield owner
        owner.latch.release()

    def next_turn(self, owner, people):
        now = owner.owned.now()
        services.start_grant(owner.owned.robot, GrantKind.TURN, now, people["bob"], now + timedelta(seconds=60))
        Robot.objects.update(cycle=Cycle.OPERATING)
        owner.owned.refresh()

    def released(self, owner, user):
        services.release_stop(owner.owned.robot, user, checked=True)

    def test_in_the_next_turn_it_is_set_back_before_the_first_motion(self, stopped, people):
        self.next_turn(stopped, people)
        self.released(stopped, people["bob"])
        mine = services.issue("turntable", people["bob"], "turn", {"angle": 1.0}, 1, stopped.owned.now()).command
        stopped.motion.run_due()  # the owner has not seen the release yet
        assert (state_of(mine), stopped.owned.driver.order) == ("queued", [])
        followed(stopped)
        stopped.motion.run_due()
        assert (state_of(mine), stopped.owned.driver.order, stopped.owned.driver.pace) == (
            "completed", ["pace", "turn"], 1.0,
        )  # fmt: skip
        assert services.settings_to_reset(stopped.owned.robot, stopped.owned.robot.spec().commands) == []
        assert services.next_seq(mine.grant) == 2, "the numbers of the controls are not used"

    def test_what_the_next_operator_has_set_already_stays(self, stopped, people):
        self.next_turn(stopped, people)
        self.released(stopped, people["bob"])
        services.issue("turntable", people["bob"], "pace", {"pace": 0.7}, 1, stopped.owned.now())
        followed(stopped)
        stopped.motion.run_due()
        stopped.config.run_due()
        assert stopped.owned.driver.order == ["pace"]
        assert stopped.owned.driver.pace == 0.7
        assert self.hand_over(stopped) == "ready"
        assert stopped.owned.driver.pace == 1.0

    def test_where_nobody_has_the_robot_it_is_set_back_and_nothing_moves(self, stopped, people):
        self.released(stopped, people["kim"])
        followed(stopped)
        stopped.motion.run_due()
        row = Command.objects.filter(kind="pace").first()
        assert (row.grant.kind, row.grant.end_code, row.state) == ("settings", "finished", "completed")
        assert (stopped.owned.driver.order, stopped.owned.driver.pace) == (["pace"], 1.0)
        assert (services.open_grant(stopped.owned.robot), Robot.objects.get().cycle) == (None, "ready")

    def test_nothing_moves_until_it_can_be_set_back(self, stopped, people):
        def fail():
            raise HardwareFault("The table did not take it.")

        self.next_turn(stopped, people)
        self.released(stopped, people["bob"])
        followed(stopped)
        stopped.owned.driver.setting = fail
        mine = services.issue("turntable", people["bob"], "turn", {"angle": 1.0}, 1, stopped.owned.now()).command
        stopped.motion.run_due()
        assert (state_of(mine), stopped.connection.connected) == ("queued", False)
        assert "pace could not be set back" in Robot.objects.get().reason
        stopped.owned.driver.setting = lambda: None
        stopped.connection.connected = True  # as after the next attempt
        stopped.motion.run_due()
        assert (state_of(mine), stopped.owned.driver.pace) == ("completed", 1.0)

    def test_an_owner_that_was_started_in_the_next_turn_finds_it_too(self, owner, issue, people):
        issue("pace", pace=0.5)
        owner.config.run_due()
        services.end_grant(services.open_grant(owner.owned.robot), "holder", "test", owner.owned.now())
        owner.owned.driver.rest.set()
        owner.connection.connected = True
        self.next_turn(owner, people)
        owner.motion.run_due()
        assert (owner.owned.driver.pace, Command.objects.filter(kind="pace").first().grant.kind) == (1.0, "turn")
