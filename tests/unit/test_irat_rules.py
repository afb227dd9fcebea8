"""The rules of the node on the robot's side, by a clock that is moved: epoch, time-out, hold."""

import ast
import importlib.util
import math
import threading

import pytest

from robots.kit.description import load
from robots.kit.drivers.irat import protocol
from tests.ros_fake import PACKAGE, SCRIPTS, fields_of

spec = importlib.util.spec_from_file_location("irat_rules", SCRIPTS / "rules.py")
rules = importlib.util.module_from_spec(spec)
spec.loader.exec_module(rules)
AHEAD = (0.1, 0.0, 0.0, 0.0, 0.0, 0.5)
NOWHERE = (0.0,) * 6


class Node:
    """Rules whose time passes only where a hold waits, or a test says so; `still`: what the odometry tells meanwhile."""

    def __init__(self, still=True):
        self.now, self.still = 100.0, still
        self.skew = 0.0  # of the base's clock
        self.rules = rules.Rules(3, clock=lambda: self.now, sleep=self.sleep, stamps=lambda: self.now)

    def sleep(self, seconds):
        self.now += seconds
        if self.still:
            self.measure()

    def measure(self, linear=0.0, angular=0.0):
        self.rules.odometry(linear, angular, self.now + self.skew)

    def rest(self):
        for _ in range(rules.STILL):
            self.measure()
        assert not self.rules.state()["moving"]

    def drive(self, epoch=5, late_s=0.05, velocity=AHEAD):
        return self.rules.drive(epoch, self.now + self.skew - late_s, velocity)


@pytest.fixture
def node():
    made = Node()
    assert made.rules.claim(5)[0]
    return made


def test_nobody_drives_without_a_claim():
    node = Node()
    for epoch in (0, 1, 5):
        assert "does not command" in node.drive(epoch)
    assert node.rules.velocity() is None


def test_epochs_only_grow_and_are_not_forgotten(node):
    assert node.rules.claim(5) == (True, "you command", 5)
    assert node.rules.claim(4) == (False, "epoch 4 is over; 5 has commanded since", 5)
    node.now += 1e6
    assert not node.rules.claim(4)[0]
    for epoch in (0, -1, 2**53):
        assert not node.rules.claim(epoch)[0]
    assert node.rules.claim(2**53 - 1)[0]
    assert "epoch 5 does not command" in node.drive()


def test_a_newer_owner_brakes_and_waits_for_rest(node):
    assert node.drive() == ""
    assert node.rules.claim(6)[0]
    assert node.rules.velocity() == (0.0, 0.0)
    assert "being held" in node.drive(6, late_s=0.0)
    node.now += 0.05
    node.rest()
    assert node.rules.state()["end"] == "replaced"
    assert node.drive(6, late_s=0.0) == ""
    assert node.rules.velocity() == (0.1, 0.5)


def test_a_velocity_is_forgotten_after_a_quarter_of_a_second(node):
    assert node.drive() == ""
    node.now += rules.FORGET_S - 0.01
    assert node.rules.velocity() == (0.1, 0.5)
    node.now += 0.02
    assert node.rules.velocity() == (0.0, 0.0), "and goes on saying so until it rests"
    assert node.rules.state()["end"] == "silence"
    node.measure(0.05)
    assert node.rules.velocity() == (0.0, 0.0)
    node.rest()
    assert node.rules.velocity() is None


@pytest.mark.parametrize("late_s", [0.51, -0.51, 1e9, math.nan, math.inf])
def test_a_velocity_that_answers_to_old_odometry_moves_nothing(node, late_s):
    assert "odometry of another time" in node.drive(late_s=late_s)
    assert node.rules.velocity() is None


@pytest.mark.parametrize("place", range(6))
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e308, 9.0])
def test_a_velocity_out_of_bounds_moves_nothing(node, place, value):
    assert node.drive(velocity=(*NOWHERE[:place], value, *NOWHERE[place + 1 :]))
    assert node.rules.velocity() is None


def test_zero_ends_a_motion_and_starts_none(node):
    assert node.drive(velocity=NOWHERE) == ""
    assert (node.rules.velocity(), node.rules.state()["motion"]) == (None, 0)
    node.drive()
    assert node.drive(velocity=NOWHERE) == ""
    node.rest()
    assert (node.rules.state()["end"], node.rules.state()["motion"]) == ("done", 1)


def test_a_hold_is_answered_at_rest_and_not_before(node):
    node.drive()
    assert node.rules.hold() == (True, "at rest")
    assert node.rules.state()["end"] == "held"
    assert node.drive(late_s=0.0) == "", "what is said after it drives again"


@pytest.mark.parametrize("skew", [0.0, 0.2, 0.45])
@pytest.mark.parametrize("sent_before_s", [0.0, 0.02, 0.3, 0.6])
def test_a_velocity_from_before_a_hold_moves_nothing_after_its_answer(node, sent_before_s, skew):
    """Behind rosbridge_server a topic may come after a service that was called later."""
    node.skew = skew
    node.measure(0.1)
    node.drive(late_s=0.0)
    stamp = node.now + skew - sent_before_s
    node.now += 0.03
    node.measure(0.1)
    assert node.rules.hold() == (True, "at rest")
    for wait in (0.0, 0.05, 0.1):
        node.now += wait
        assert node.rules.drive(5, stamp, AHEAD)
        assert (node.rules.velocity(), node.rules.state()["moving"]) == (None, False)
    assert node.drive(late_s=0.1) == ""


def test_a_velocity_that_another_has_overtaken_moves_nothing(node):
    assert node.drive(late_s=0.0, velocity=NOWHERE) == ""
    assert "overtaken" in node.drive(late_s=0.05)
    assert node.rules.velocity() is None
    assert node.drive(late_s=0.0) == "", "two may answer to the same odometry"


@pytest.mark.parametrize("step", [-3600.0, -0.6, -0.3, 3600.0])
def test_a_step_of_the_clock_of_the_stamps_locks_nobody_out_for_long(node, step):
    node.drive()
    node.rules.hold()
    stamps = node.now + step
    node.rules._stamps = lambda: stamps
    tries = 0
    while node.rules.drive(5, stamps - 0.05, AHEAD):
        stamps += 0.1
        tries += 1
        assert tries <= 10, "a second"


@pytest.mark.parametrize("measured", [None, 0.05, math.nan])
def test_a_hold_without_rest_says_so_and_goes_on_holding(measured):
    node = Node(still=False)
    node.rules.claim(5)
    node.drive()
    if measured is not None:
        node.sleep = lambda seconds: (setattr(node, "now", node.now + seconds), node.measure(measured))
        node.rules._sleep = node.sleep
    done, why = node.rules.hold()
    assert (done, "does not say rest" in why) == (False, True)
    assert node.rules.velocity() == (0.0, 0.0)
    assert "being held" in node.drive(late_s=0.0)
    assert node.rules.state()["moving"]
    node.rest()
    assert node.drive() == ""


def test_one_still_message_is_no_rest(node):
    node.drive()
    node.drive(velocity=NOWHERE)
    for _ in range(5):
        node.measure()
        node.measure(0.05)
    assert node.rules.state()["moving"]


def test_an_owner_that_keeps_telling_zero_sees_it_rest(node):
    """As it does while a motion pauses: each 0.1 s, with two messages of the odometry between."""
    node.drive()
    for _ in range(2):
        node.drive(velocity=NOWHERE)
        for _ in range(2):
            node.now += 0.05
            node.measure()
    assert (node.rules.state()["moving"], node.rules.state()["end"]) == (False, "done")
    node.drive()
    node.drive(velocity=NOWHERE)
    for _ in range(rules.STILL - 1):
        node.measure()
    node.drive()
    node.drive(velocity=NOWHERE)
    node.measure()
    assert node.rules.state()["moving"], "one still message after a velocity is no rest"


def test_holds_that_are_too_many_brake_all_the_same(node):
    waiting, free = threading.Semaphore(0), threading.Event()

    def sleep(seconds):
        waiting.release()
        assert free.wait(60)
        node.rest()

    node.rules._sleep = sleep
    threads = [threading.Thread(target=node.rules.hold) for _ in range(rules.MOST_HOLDS)]
    for thread in threads:
        thread.start()
    for _ in threads:
        assert waiting.acquire(timeout=60)
    done, why = node.rules.hold()
    assert (done, "holds wait" in why) == (False, True)
    assert node.rules.velocity() == (0.0, 0.0)
    free.set()
    for thread in threads:
        thread.join(60)
    assert node.rules.velocity() is None


def test_a_robot_that_does_not_follow_is_stalled(node):
    for _ in range(8):
        node.drive()
        node.measure(0.01, 0.02)
        node.now += 0.05
    assert node.rules.state()["stalled"]
    node.measure(0.1, 0.5)
    assert not node.rules.state()["stalled"]


def test_the_charger_is_told(node):
    for current, charging in ((1.2, True), (0.0, False), (-0.01, False), (math.nan, False)):
        node.rules.charger(current)
        assert node.rules.state()["charging"] is charging


def test_node_and_driver_agree(node):
    assert (
        load("irat")["motion"]["forget_s"], protocol.LATE_S, protocol.REST_S, protocol.LARGEST_EPOCH,
    ) == (rules.FORGET_S, rules.LATE_S, rules.REST_S, rules.LARGEST_EPOCH)  # fmt: skip
    drive = protocol.Drive(protocol.Velocity(0.1, 0.5), 5, 12.25).encode()
    assert tuple(drive) == tuple(name for name, _ in fields_of((PACKAGE / "msg/Drive.msg").read_text()))
    status = tuple(name for name, _ in fields_of((PACKAGE / "msg/State.msg").read_text()))
    assert set(protocol.Status.decode(node.rules.state()).encode()) == set(node.rules.state()) == set(status)
    told = (PACKAGE / "srv/Status.srv").read_text().split("---")[1]
    assert fields_of(told) == fields_of((PACKAGE / "msg/State.msg").read_text())


@pytest.mark.parametrize("file", sorted(SCRIPTS.glob("*.py")), ids=lambda file: file.name)
def test_the_scripts_are_python_3_8(file):
    ast.parse(file.read_text(), feature_version=(3, 8))
