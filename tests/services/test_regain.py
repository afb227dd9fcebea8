"""A lease that ran out: hold, then take the robot again in the same process, under a new epoch."""

import threading
from datetime import timedelta
from unittest.mock import Mock

import pytest

from robots import bus, services
from robots.kit.contract.errors import StaleEpoch
from robots.kit.contract.session import Outcome, RobotState
from robots.models import Command, Grant, Lease
from robots.states import CommandState
from tests.conftest import wait_for
from tests.services.owner import Arm, made_owner
from tests.waiting import CEILING_S
from workers.robot.machine import Machine

pytestmark = [
    pytest.mark.service, pytest.mark.django_db(transaction=True), pytest.mark.parametrize("which", ["pa10"], indirect=True),
]  # fmt: skip


@pytest.fixture
def told():
    """What became of driver and queues, in order."""
    return []


@pytest.fixture
def owner(robot, people, told):
    class Opened(Arm):
        def connect(self):
            told.append(("connect", made.lease.epoch))
            return self.latest()

        def close(self):
            told.append("close")

    made = made_owner(
        robot, people, listen=lambda *what: told.append(what), on_lost=lambda: told.append("left"),
        machine=Machine(lambda *_: Opened()),
    )  # fmt: skip
    made.owned.driver = Opened()
    made.connection.connected = True
    return made


def again(owner):
    owner.regain.regain()


def issue(owner, people, seq, kind="ready"):
    return services.issue(owner.owned.robot.slug, people["ada"], kind, {}, seq, owner.owned.now()).command


def run(owner, command):
    command = Command.objects.select_related("grant", "robot").get(pk=command.pk)
    owner.motion.run_one(command)
    command.refresh_from_db()
    return command


def lapse(owner):
    owner.clock.go(3.1)
    owner.link.note_answer()


@pytest.mark.asvs("16.5.3")
def test_an_earlier_permit_refuses_for_good(owner):
    owner.lane.gate.open_for(Grant.objects.get())
    permits = [owner.lane.gate.permit(owner.lease.epoch)]
    permits[0]()
    for _ in range(3):
        lapse(owner)
        for permit in permits:
            with pytest.raises(StaleEpoch):
                permit()
        again(owner)
        for permit in permits:
            with pytest.raises(StaleEpoch):
                permit()
        permits.append(owner.lane.gate.permit(owner.lease.epoch))
        permits[-1]()


def test_a_renewal_that_comes_too_late_brings_nothing_back(owner, monkeypatch):
    monkeypatch.setattr(owner.lease, "measure_offset", lambda: lapse(owner))
    owner.lease.renew()
    assert not owner.lease.valid
    owner.lease.renew()
    assert (owner.lease.valid, owner.lease.lost) == (False, False)


def test_what_ran_ends_unknown_and_what_waited_is_not_begun(owner, people, told):
    running, waiting = issue(owner, people, 1), issue(owner, people, 2)
    owner.owned.driver.on_the_way = lambda: lapse(owner)
    assert run(owner, running).state == "unknown"
    old = owner.lease.epoch
    again(owner)
    waiting.refresh_from_db()
    assert (waiting.state, "start again" in waiting.reason) == ("expired", True)
    slug = owner.owned.robot.slug
    assert told == [
        (bus.queue_name(slug, old), False), "close", ("connect", old + 1), (bus.queue_name(slug, old + 1), True),
    ]  # fmt: skip
    assert run(owner, issue(owner, people, 3)).state == "completed"


def test_what_was_claimed_and_not_yet_said_was_not_carried_out(owner, people):
    command = issue(owner, people, 1)
    spoken = []

    class Silent(Arm):
        def execute(self, kind, args, permit, on_stage):
            lapse(owner)
            permit()
            spoken.append(kind)

    owner.owned.driver = Silent()
    assert (run(owner, command).state, spoken) == ("rejected", [])
    assert "not carried out" in command.__class__.objects.get(pk=command.pk).reason


def test_an_end_that_is_heard_after_the_lease_ran_out_is_unknown_too(owner, people):
    """Another owner that had the robot by then would have moved it."""

    class Late(Arm):
        def execute(self, kind, args, permit, on_stage):
            permit()
            on_stage("sent")
            lapse(owner)
            return Outcome({}, RobotState(0.0, (0.0,) * 7, (0.0,) * 6, False, True))

    owner.owned.driver = Late()
    assert run(owner, issue(owner, people, 1)).state == "unknown"


def test_who_finds_another_owner_holds_and_leaves(owner, told):
    lapse(owner)
    Lease.objects.update(epoch=owner.lease.epoch + 1, pid=1, expires_at=owner.owned.now() + timedelta(seconds=3))
    again(owner)
    assert (told[-1], owner.owned.running, owner.lease.valid) == ("left", False, False)


def test_a_robot_at_rest_stays_as_it_was(owner, people):
    before = services.open_grant(owner.owned.robot)
    lapse(owner)
    again(owner)
    owner.owned.robot.refresh_from_db()
    assert (owner.owned.robot.cycle, services.open_grant(owner.owned.robot)) == ("operating", before)


def test_a_stage_that_the_database_lost_is_no_untrue_word(owner, people, monkeypatch):
    """The robot was told, the row does not know it: it is not called rejected."""
    from django.db import OperationalError

    from workers.commands import rows

    stored, lost = rows.advance, []

    def advance(*told):
        lost.append(told)
        if len(lost) <= 2:  # that it was sent and acknowledged
            raise OperationalError("locked")
        return stored(*told)

    monkeypatch.setattr(rows, "advance", advance)
    owner.owned.driver.on_the_way = owner.latch.forbid
    try:
        assert run(owner, issue(owner, people, 1)).state == CommandState.CANCELLED
    finally:
        owner.latch.release()


def test_the_watch_holds_without_the_disk(owner, told, monkeypatch):
    """Any access to a file in the watch would keep the hold waiting while the disk stalls."""

    def stalls(*_, **__):
        told.append("disk")
        owner.owned.running = False

    monkeypatch.setattr("pathlib.Path.touch", stalls)
    monkeypatch.setattr("workers.guard.watch.log.warning", lambda *_: told.append(("log", owner.owned.driver.holds)))
    owner.owned.driver.hold = held = Mock(side_effect=lambda: setattr(owner.owned.driver, "holds", 1))
    watch = threading.Thread(target=owner.watch.loop)
    watch.start()
    wait_for(lambda: ("log", 1) in told, 10, "the hold of a lease that ran out, before a line in the log")
    assert held.called and "disk" not in told
    told.clear()
    owner.heartbeat.loop()
    watch.join(CEILING_S)
    assert told == ["disk"], "the heartbeat has a thread of its own"
