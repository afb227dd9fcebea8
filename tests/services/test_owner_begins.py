"""An owner begins: nothing moves before a stop can be heard, and never without a grant; what fails is not offered."""

from dataclasses import replace

import pytest

from queueing import services as queue
from queueing.models import Ticket
from robots import services
from robots.kit.contract.errors import GrantOver, LineGone, Stopped
from robots.kit.packets import Notice
from robots.models import Grant, Incident, Robot
from robots.states import Cycle, GrantEnd, GrantKind
from tests.services.owner import Arm, followed, made_owner

pytestmark = [
    pytest.mark.service, pytest.mark.django_db(transaction=True), pytest.mark.parametrize("which", ["pa10"], indirect=True),
]  # fmt: skip


class Switched(Arm):
    """A driver whose robot was switched off and on: it is not ready until it has recovered, which moves it."""

    def __init__(self):
        super().__init__()
        self.recovered, self.gone, self.opened, self.open, self.fault = [], False, 0, False, ""

    def latest(self):
        return replace(super().latest(), ready=bool(self.recovered), fault=self.fault)

    def state(self):
        if self.gone or not self.open:
            raise LineGone("The arm does not answer.")
        return self.latest()

    def hold(self):
        self.state()
        return super().hold()

    def connect(self):
        if self.gone:
            raise LineGone("The arm does not answer.")
        self.opened, self.open = self.opened + 1, True
        return self.latest()

    def close(self):
        self.open = False

    def recover(self, permit):
        permit()
        self.recovered.append("moved")
        return self.latest()


@pytest.fixture
def owner(robot, people, monkeypatch):
    made = made_owner(robot, people)
    made.owned.driver = Switched()
    monkeypatch.setattr(made.threads, "begin", lambda *_: None)
    return made


def mended(owner):
    owner.clock.go(5.0)
    assert owner.lease._try()
    owner.link.note_answer()
    owner.connection.mend()
    return owner.owned.driver.recovered


def test_a_robot_that_is_not_ready_moves_only_after_everything_listens(owner):
    owner.start()
    assert owner.owned.driver.recovered == []
    assert Robot.objects.get().reason == "The robot is not ready after its connection came back."
    assert Incident.objects.count() == 1
    owner.pictures.still_id = 7
    assert mended(owner) == ["moved"]
    assert (owner.connection.connected, owner.pictures.still_id, Robot.objects.get().reason) == (True, 0, "")


@pytest.fixture
def told(monkeypatch):
    """The notices to whoever watches, in order."""
    found = []
    monkeypatch.setattr(
        "robots.bus.publish", lambda _slug, event: found.append(event.text) if isinstance(event, Notice) else None
    )
    return found


def test_the_operator_is_told_that_the_robot_was_reset(owner, told):
    owner.start()
    mended(owner)
    assert told == ["The robot was reset and may stand elsewhere. Look, then go on."]
    owner.connection.later(0.0)
    mended(owner)
    assert told[1:] == ["The robot answers again. Look at the picture, then go on."]


def test_a_stop_that_nobody_heard_is_kept_from_the_beginning_and_its_release_moves_nothing(owner, people, told):
    services.stop(owner.owned.robot, people["ada"], owner.owned.now())
    assert not owner.latch.latched
    owner.start()
    assert owner.latch.latched
    assert mended(owner) == []
    assert Robot.objects.get().reason == "The robot is stopped."
    followed(owner)
    services.release_stop(owner.owned.robot, people["kim"], checked=True)
    followed(owner)
    assert mended(owner) == []
    assert owner.connection.connected
    assert told[-1].startswith("The robot is not ready. Your next command resets it")
    owner.connection.later(0.0)
    assert mended(owner) == [], "nobody has given a command since"
    command = services.issue(owner.owned.robot.slug, people["ada"], "home", {}, 1, owner.owned.now()).command
    type(command).objects.filter(pk=command.pk).update(accepted_at=command.created_at)
    owner.connection.later(0.0)  # another fault, after that command
    assert mended(owner) == ["moved"]


def test_a_robot_that_waits_for_the_release_stays_connected_and_confirms_the_stop(owner, people):
    services.stop(owner.owned.robot, people["ada"], owner.owned.now())
    owner.start()
    for _ in range(3):
        followed(owner)
        assert mended(owner) == []
        followed(owner)
    assert Robot.objects.get().stop_confirmed
    assert [found.code for found in Incident.objects.all()] == ["hardware_fault"]
    assert owner.owned.driver.opened == 1
    owner.owned.driver.gone = True
    mended(owner)
    owner.owned.driver.gone = False
    mended(owner)
    assert owner.owned.driver.opened == 2, "a line that is gone is opened again"


def test_a_robot_is_not_recovered_for_a_turn_that_is_over(owner):
    owner.start()
    owner.clock.go(61.0)
    assert mended(owner) == []
    assert owner.lane.gate.grant_over


def test_nothing_passes_before_there_is_a_grant(owner):
    owner.lane.gate.grant_id = 0
    with pytest.raises(GrantOver):
        owner.lane.gate.check()
    owner.latch.forbid()
    with pytest.raises(Stopped):
        owner.lane.gate.check()


def test_a_stop_of_which_only_the_owner_heard_is_written_with_its_time(owner, people):
    owner.connection.connected = True
    followed(owner)
    owner.stopping.halt("bus")
    followed(owner)
    row = Robot.objects.get()
    assert (row.stop_latched, row.stopped_at) == (True, owner.owned.now())


def test_a_robot_that_fails_while_it_is_offered_is_taken_back_and_the_place_kept(owner, people):
    services.end_grant(Grant.objects.get(), GrantEnd.FINISHED, "test", owner.owned.now())
    robot = owner.owned.robot
    Robot.objects.update(cycle=Cycle.READY, clearance_required=False, enabled=True)
    queue.join(robot, people["ada"], owner.owned.now())
    queue.tick(owner.owned.now())
    assert (Robot.objects.get().cycle, Ticket.objects.get().state) == ("offered", "offered")
    owner.owned.driver.gone = True
    owner.connection.lost_while_idle(LineGone("The arm does not answer."))
    queue.tick(owner.owned.now())
    assert (Robot.objects.get().cycle, Ticket.objects.get().state) == ("fault", "waiting")
    owner.owned.driver.gone = False
    owner.owned.driver.recovered.append("ready by itself")
    owner.connection.mend()
    assert Robot.objects.get().cycle == "handover"


@pytest.fixture
def offered(owner, people):
    """The owner of a robot that is offered to ada, and says of itself that it failed."""
    services.end_grant(Grant.objects.get(), GrantEnd.FINISHED, "test", owner.owned.now())
    Robot.objects.update(cycle=Cycle.READY, clearance_required=False, enabled=True)
    queue.join(owner.owned.robot, people["ada"], owner.owned.now())
    queue.tick(owner.owned.now())
    owner.owned.driver.connect()
    owner.owned.driver.fault = "Range error: pushed."
    owner.connection.connected = True
    return owner


def published(owner):
    """Let the loop of states go round once."""
    owner.owned.running, owner.streams.publish = True, lambda: setattr(owner.owned, "running", False)
    owner.states.loop()
    owner.owned.running = True
    queue.tick(owner.owned.now())
    return Robot.objects.get().cycle, Ticket.objects.get().state


def test_a_robot_that_says_it_failed_while_it_is_offered_is_taken_back(offered):
    assert published(offered) == ("fault", "waiting")
    assert Robot.objects.get().reason == "Range error: pushed."
    offered.connection.mend()
    assert published(offered) == ("handover", "waiting")


def test_under_a_stop_it_stays_so_that_its_release_moves_nothing(offered, people):
    services.stop(offered.owned.robot, people["kim"], offered.owned.now())
    followed(offered)
    assert published(offered) == ("offered", "offered")
    services.release_stop(offered.owned.robot, people["kim"], checked=True)
    followed(offered)
    assert published(offered) == ("offered", "offered")


@pytest.mark.parametrize(("cycle", "kind"), [(Cycle.OPERATING, GrantKind.TURN), (Cycle.READY, GrantKind.JOB)])
def test_what_fails_under_a_grant_is_mended_by_its_command(owner, cycle, kind):
    Robot.objects.update(cycle=cycle)
    Grant.objects.update(kind=kind)
    owner.owned.driver.connect()
    owner.owned.driver.fault, owner.connection.connected = "Range error: pushed.", True
    owner.owned.running, owner.streams.publish = True, lambda: setattr(owner.owned, "running", False)
    owner.states.loop()
    assert (Robot.objects.get().cycle, owner.connection.connected) == (cycle, True)


def test_a_robot_that_is_back_at_once_does_not_stay_in_fault(owner, monkeypatch):
    """The loops of state and control share the connection: one notes the loss while the other mends it."""
    services.end_grant(Grant.objects.get(), GrantEnd.FINISHED, "test", owner.owned.now())
    Robot.objects.update(cycle=Cycle.READY)
    owner.connection.connected, note = True, owner.connection._unready

    def meanwhile(*args, **options):
        if not owner.connection.connected:
            owner.connection.mend()
        note(*args, **options)

    monkeypatch.setattr(owner.connection, "_unready", meanwhile)
    owner.connection.lost_while_idle(LineGone("The arm does not answer."))
    if not owner.connection.connected:
        owner.connection.mend()
    assert (owner.connection.connected, Robot.objects.get().cycle) == (True, "handover")


def test_a_robot_that_is_switched_off_is_at_no_fault_when_its_connection_is_lost(owner):
    services.end_grant(Grant.objects.get(), GrantEnd.FINISHED, "test", owner.owned.now())
    Robot.objects.update(enabled=False, cycle=Cycle.OFFLINE, reason=services.lockout.OFF)
    owner.connection.connected = True
    owner.connection.lost_while_idle(LineGone("The arm does not answer."))
    assert (Robot.objects.get().cycle, Robot.objects.get().reason) == ("offline", services.lockout.OFF)


def test_each_loss_of_the_connection_is_an_incident_and_each_attempt_is_not(owner):
    driver, connection = owner.owned.driver, owner.connection
    services.end_grant(Grant.objects.get(), GrantEnd.FINISHED, "test", owner.owned.now())
    driver.recovered.append("ready by itself")
    Robot.objects.update(cycle=Cycle.READY)
    for losses in (1, 2):
        driver.gone = True
        connection.later(0.0)  # as at a new address
        for _ in range(3):
            owner.owned.clock.go(60)
            connection.mend()
        assert (Robot.objects.get().reason, Incident.objects.count()) == ("The arm does not answer.", losses)
        driver.gone = False
        owner.owned.clock.go(60)
        connection.connect()  # of a lease that was taken again; the row is read again only later
        assert (Robot.objects.get().cycle, Robot.objects.get().reason) == ("handover", "")


def test_a_turn_goes_on_without_the_words_of_a_fault_that_is_over(owner):
    owner.owned.driver.recovered.append("ready by itself")
    owner.owned.driver.gone = True
    owner.connection.connect()
    assert Robot.objects.get().reason == "The arm does not answer."
    owner.owned.driver.gone = False
    owner.connection.connect()  # of a lease that was taken again
    assert (Robot.objects.get().cycle, Robot.objects.get().reason) == ("operating", "")


@pytest.mark.parametrize(
    ("address", "words"),
    [("sim:pa10", "The robot's simulator is starting."), ("tcp:192.0.2.1:9000", "The arm does not answer.")],
)
def test_a_robot_that_is_switched_on_a_little_after_its_owner_is_no_incident(owner, caplog, address, words):
    caplog.set_level("INFO")
    owner.owned.robot.address = address
    driver = owner.owned.driver
    driver.gone = True
    owner.start()
    assert (Robot.objects.get().reason, Incident.objects.count()) == (words, 0)
    mended(owner)
    assert "no connection" not in caplog.text, "a start as it should be"
    driver.gone = False
    assert mended(owner) == ["moved"]
    assert (Robot.objects.get().reason, Incident.objects.count()) == ("", 0)
    driver.gone = True
    owner.connection.later(0.0)
    mended(owner)
    assert Incident.objects.count() == 1, "later each loss is one at once"


def test_a_robot_that_stays_away_at_the_beginning_is_one_incident(owner):
    owner.owned.driver.gone = True
    owner.start()
    for _ in range(5):
        mended(owner)
    assert [found.text for found in Incident.objects.all()] == ["The arm does not answer."]
    owner.start()  # of the next owner, which finds the same
    for _ in range(5):
        mended(owner)
    assert Incident.objects.count() == 1
