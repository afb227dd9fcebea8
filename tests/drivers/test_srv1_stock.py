"""A rover with its maker's firmware: driven by hand in bursts, never by itself; in virtual time, over its wire."""

from itertools import pairwise

import pytest

from robots.kit.contract.errors import BadRequest, ControlsReleased, HardwareFault, LineSilent, MotionHeld
from robots.kit.drivers.srv1.driver import Driver
from robots.kit.drivers.srv1.stock import BY_HAND_ONLY, NOT_AT_REST
from simulators.srv1.simulator import Simulator
from tests.world.streams import Door, Network
from tests.world.world import World


class Rig:
    """The simulator in a process of its world, and a driver that a person calls."""

    def __init__(self, folder, stock):
        self.world = World(1)
        self.cable = Network(self.world)
        self.sent = []
        self.sim = Simulator(
            folder, 1, self.world, lambda: self.world.now().timestamp(), self.world, stock=stock
        )  # fmt: skip
        self.world.spawn(self._run, "simulator", self.world.process("simulator", delayed=False))
        rig = self

        class InWorld(Driver):
            clock = rig.world

            @staticmethod
            def opened(host, port, seconds):
                return rig.cable.connect(host, port, seconds, rig.sent.append)

        self.driver = InWorld("127.0.0.1:10001", {"epoch": 1})

    def _run(self):
        self.sim.listen(Door(self.cable))
        self.sim.run()

    def do(self, act, seconds=30):
        """Call something in a process of the world; return what it returned, or raise what it raised."""
        told = []

        def run():
            try:
                told.append(act())
            except Exception as error:
                told.append(error)

        self.world.spawn(run, "person", self.world.process("person", delayed=False))
        self.world.until(lambda: told, seconds, "the end of a call")
        if isinstance(told[0], Exception):
            raise told[0]
        return told[0]

    def other(self, *messages):
        """Have another client say these, and leave."""
        end = self.cable.connect("other", 10001, 1.0)
        for data in messages:
            end.sendall(data)
            self.world.sleep(0.1)
        end.close()
        self.world.sleep(0.5)

    def close(self):
        self.world.close()
        self.sim.journal.close()


@pytest.fixture
def rig(request, tmp_path):
    made = Rig(tmp_path, getattr(request, "param", True))
    made.world.sleep(3)
    yield made
    made.close()


def released_after(rig, seconds):
    until = rig.world.monotonic() + seconds

    def permit():
        if rig.world.monotonic() > until:
            raise ControlsReleased("let go")

    return permit


def test_it_is_driven_in_bursts_and_says_nothing_that_it_does_not_know(rig):
    state = rig.do(rig.driver.connect)
    assert (state.ready, state.pose, state.moving) == (True, (), False)
    assert state.values["sonar"] > 1.0
    assert "battery" not in state.values
    x = rig.sim.world.plant.pose[0]
    with pytest.raises(ControlsReleased):
        rig.do(lambda: rig.driver.execute(
            "drive", {"forward": 1.0, "turn": 0.0}, released_after(rig, 3.0), lambda stage: None
        ))  # fmt: skip
    rig.world.sleep(0.5)
    assert not rig.sim.moving
    assert rig.sim.world.plant.pose[0] > x + 0.2
    bursts = [data for data in rig.sent if data[:1] == b"M"]
    assert len(bursts) > 5
    assert all(len(data) == 4 and 1 <= data[3] <= 10 for data in bursts), "each ends by itself within 0.1 s"


def test_what_it_cannot_do_is_refused_and_nothing_is_sent(rig):
    rig.do(rig.driver.connect)
    sent = len(rig.sent)
    for kind, args in (("patrol", {}), ("go", {"x": 1.2, "y": 4.0}), ("mission", {"text": "read"}), ("look", {})):
        with pytest.raises(BadRequest, match=BY_HAND_ONLY):
            rig.do(lambda kind=kind, args=args: rig.driver.execute(kind, args, lambda: None, lambda stage: None))
    assert len(rig.sent) == sent
    assert not rig.sim.moving


def test_a_hold_ends_the_bursts_for_good(rig):
    rig.do(rig.driver.connect)
    ended = []

    def drive():
        try:
            rig.driver.execute("drive", {"forward": 1.0, "turn": 0.0}, lambda: None, lambda stage: None)
        except MotionHeld as error:
            ended.append(error)

    rig.world.spawn(drive, "driving", rig.world.process("driving", delayed=False))
    rig.world.until(lambda: rig.sim.moving, 10, "a motion")
    assert not rig.do(rig.driver.hold).moving
    rig.world.until(lambda: ended, 5, "the end of the drive")
    rig.world.sleep(1)
    assert not rig.sim.moving
    begun = rig.sim.journal.counts["motion"]
    rig.world.sleep(3)
    assert rig.sim.journal.counts["motion"] == begun


def test_no_burst_is_said_twice_when_the_rover_is_silent(rig):
    """After silence the line is put in order; the next burst needs another permit."""
    rig.do(rig.driver.connect)
    rig.sim.faults.set("mute")
    permits = []

    def permit():
        permits.append(rig.world.monotonic())
        if len(permits) > 40:
            raise ControlsReleased("let go")

    with pytest.raises(Exception, match="does not answer"):
        rig.do(lambda: rig.driver.execute("drive", {"forward": 1.0, "turn": 0.0}, permit, lambda stage: None))
    assert sum(data[:1] == b"M" for data in rig.sent) == 1
    assert all(a <= b for a, b in pairwise(permits))


FASTEST = bytes((ord("M"), 60, 60, 0))  # which our driver never says: it has no end


def test_what_another_client_left_running_is_stopped_by_who_connects(rig):
    rig.other(FASTEST)
    assert rig.sim.moving
    state = rig.do(rig.driver.connect)
    assert state.moving, "it rolls still"
    assert not rig.do(rig.driver.hold).moving
    assert not rig.sim.moving
    x = rig.sim.world.plant.pose[0]
    rig.world.sleep(3)
    assert rig.do(rig.driver.state).moving is False
    assert rig.sim.world.plant.pose[0] == pytest.approx(x, abs=0.01)


def test_a_rover_that_turns_on_the_spot_counts_as_moving_too(rig):
    rig.other(bytes((ord("M"), 60, 256 - 60, 0)))
    assert rig.do(rig.driver.connect).moving


@pytest.mark.parametrize("cut", [b"M", b"M\x3c", b"M\x3c\x3c", b"F\x3c", b"$A"])
def test_what_another_client_broke_off_moves_nothing_for_who_connects(rig, cut):
    rig.other(cut)
    rig.do(rig.driver.connect)
    rig.do(rig.driver.hold)
    begun = rig.sim.journal.counts["motion"]
    rig.world.sleep(3)
    assert not rig.sim.moving
    assert rig.sim.journal.counts["motion"] == begun


@pytest.mark.parametrize("rig", [True, False], indirect=True, ids=["stock", "ours"])
def test_the_failsafe_speeds_of_another_client_are_not_taken_when_the_line_is_lost(rig):
    """They are taken after 2 s of silence, so nobody would have permitted that motion."""
    rig.other(b"M\x01\x01\x01", b"F\x3c\x3c")
    rig.do(rig.driver.connect)
    begun = rig.sim.journal.counts["motion"]
    rig.cable.pull()
    rig.world.sleep(10)
    assert rig.sim.journal.counts["motion"] == begun


def test_a_burst_that_is_not_answered_leaves_a_rover_that_may_run(rig):
    """It says so until it was held and asked: by the counts of its wheels, twice."""
    rig.do(rig.driver.connect)
    rig.sim.faults.set("mute")
    with pytest.raises(LineSilent):
        rig.do(lambda: rig.driver.execute(
            "drive", {"forward": 1.0, "turn": 0.0}, lambda: None, lambda stage: None
        ))  # fmt: skip
    with pytest.raises(LineSilent):
        rig.do(rig.driver.hold)
    rig.sim.faults.clear()
    assert rig.driver.latest().moving
    assert rig.do(rig.driver.state).moving, "it was not asked whether it rests"
    assert not rig.do(rig.driver.hold).moving
    assert rig.sent[-8:].count(b"$E") == 2
    assert not rig.sim.moving


def test_a_rover_that_does_not_heed_a_stop_is_not_said_to_rest(rig):
    rig.do(rig.driver.connect)

    def shorted():
        """Be a motor driver that is at full power, whatever it is told."""
        while True:
            with rig.sim._lock:
                rig.sim.drive.percent(60, 60)
            rig.sim._woken.set()
            rig.world.sleep(0.01)

    rig.world.spawn(shorted, "shorted", rig.world.process("shorted", delayed=False))
    rig.world.sleep(1)
    with pytest.raises(HardwareFault, match=NOT_AT_REST):
        rig.do(rig.driver.hold)
    assert rig.do(rig.driver.state).moving
