"""The owner's client, a rosbridge_server by its conversion rules, and the node on the robot's side, for ROS 1 and ROS 2.

No ROS is here: `tests.ros_fake` and `tests.rosbridge_fake` stand for it.
"""

import json
import math
import threading
import time

import cv2
import numpy as np
import pytest
from websockets.sync.client import connect

from robots.kit.contract.errors import ControllerRestarted, LineBusy, MotionHeld
from robots.kit.drivers.irat.driver import Driver
from robots.kit.drivers.irat.line import IratLine
from robots.kit.drivers.irat.protocol import Velocity
from tests.conftest import wait_for
from tests.ros_fake import Ordered, Ros, start_node
from tests.rosbridge_fake import Bridge

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

AHEAD = Velocity(0.1, 0.5)
PICTURE = cv2.imencode(".jpg", np.random.default_rng(1).integers(0, 255, (60, 104), np.uint8))[1].tobytes()


class Base:
    """The robot's own driver: it follows velocities and tells odometry, ranges and battery as real ones do."""

    def __init__(self, ros):
        self.ros, self.x, self.heard, self.stopped = ros, 0.0, [], True
        self.velocity = (0.0, 0.0)
        ros.listen("base/cmd_vel", ros.message("geometry_msgs/Twist"), self.drive)
        self.running = True
        threading.Thread(target=self.run, daemon=True).start()

    def drive(self, twist):
        self.velocity = (twist.linear.x, twist.angular.z)
        self.heard.append((time.monotonic(), self.velocity))

    def run(self):
        while self.running:
            self.x += self.velocity[0] * 0.02
            self.tell()
            time.sleep(0.02)

    def tell(self):
        ros = self.ros
        odometry = ros.message("nav_msgs/Odometry")()
        odometry.header.stamp = ros.now()
        odometry.pose.pose.position.x, odometry.pose.pose.orientation.w = self.x, 1.0000001
        odometry.twist.twist.linear.x, odometry.twist.twist.angular.z = self.velocity
        odometry.pose.covariance = [math.nan] * 36
        ros.publish("irat/odom", odometry)
        scan = ros.message("sensor_msgs/LaserScan")()
        scan.ranges, scan.range_max = [0.2, math.inf, math.nan], 0.4000000059604645
        ros.publish("irat/ranges", scan)
        battery = ros.message("sensor_msgs/BatteryState")()
        battery.voltage, battery.power_supply_status = 7.4, 2
        for name in ("current", "charge", "capacity", "design_capacity", "percentage"):
            setattr(battery, name, math.nan)
        ros.publish("irat/battery", battery)
        ros.publish("irat/charger_current", ros.message("std_msgs/Float32")(data=-0.001))
        picture = ros.message("sensor_msgs/CompressedImage")(format="rgb8; jpeg compressed bgr8", data=list(PICTURE))
        picture.header.stamp = ros.now()
        ros.publish("irat/camera/image/compressed", picture)


@pytest.fixture(params=[1, 2], ids=["ros1", "ros2"])
def ros(request):
    graph = Ros(request.param)
    base = graph.base = Base(graph)
    start_node(graph)
    graph.bridge = Bridge(graph)
    yield graph
    graph.up = base.running = False
    graph.bridge.close()


@pytest.fixture
def owner(ros):
    made = IratLine(ros.bridge.address, 7)
    made.open()
    for newest in (made.odometry, made.ranges, made.battery, made.charger, made.status):
        newest.wait(5)
    yield made
    made.close()


def state(ros):
    """Return what the node says, asked without rosbridge."""
    request, answer = ros.services["/irat/status"]
    return answer(request())


def drive_until(line, holds, velocity=AHEAD):
    def step():
        line.drive(velocity)
        return holds()

    wait_for(step, 10, "the motion")


def test_what_a_real_robot_tells_is_read(owner, ros):
    assert owner.odometry.value.heading == pytest.approx(0, abs=1e-3)
    assert abs(owner.odometry.value.stamp - time.time()) < 5
    assert (owner.ranges.value.right, owner.ranges.value.ahead, owner.ranges.value.left) == pytest.approx(
        (0.2, 0.4, 0.4)
    )
    assert owner.battery.value.share == pytest.approx(0.5)
    assert owner.charger.value == 0.0
    assert owner.bridge.unreadable == 0


def test_the_owner_drives_and_holds(owner, ros):
    drive_until(owner, lambda: ros.base.x > 0.02)
    owner.hold()
    assert ros.base.velocity == (0.0, 0.0)
    status = owner.ask()
    assert (status.moving, status.end, status.epoch, status.motion) == (False, "held", 7, 1)
    assert ros.bridge.said == [], "rosbridge has taken each of the owner's messages"


def test_silence_stops_the_base(owner, ros):
    drive_until(owner, lambda: ros.base.x > 0.01)
    wait_for(lambda: not state(ros).moving, 5, "rest")
    assert ros.base.velocity == (0.0, 0.0)
    assert state(ros).end == "silence"


def test_the_end_of_the_connection_stops_the_base(owner, ros):
    drive_until(owner, lambda: ros.base.x > 0.01)
    owner.close()
    wait_for(lambda: not state(ros).moving, 5, "rest")
    assert ros.base.velocity == (0.0, 0.0)


def test_a_newer_owner_takes_over_and_the_older_one_moves_nothing(owner, ros):
    drive_until(owner, lambda: ros.base.x > 0.01)
    newer = IratLine(ros.bridge.address, 8)
    newer.open()
    owner.drive(AHEAD)
    wait_for(lambda: any("epoch 7 does not command" in said for said in ros.complaints), 5, "the older one's refusal")
    wait_for(lambda: not state(ros).moving, 5, "rest")
    assert state(ros).end == "replaced"
    for _ in range(5):
        owner.drive(AHEAD)
    assert (state(ros).moving, state(ros).motion) == (False, 1)
    wait_for(lambda: owner.status.value.epoch == 8, 5, "the robot's word of it")
    with pytest.raises(LineBusy):
        owner.obeys()
    with pytest.raises(LineBusy, match="is over"):
        owner.claim()
    at = ros.base.x
    drive_until(newer, lambda: ros.base.x > at + 0.01)
    newer.close()


def test_what_a_network_has_kept_back_moves_nothing(owner, ros):
    kept_back = {**drive_of(owner.odometry.value), "epoch": 7}
    time.sleep(0.8)
    owner.bridge.publish("/irat/drive", kept_back)
    owner.bridge.publish("/irat/drive", {"epoch": 7, "twist": AHEAD.encode()})
    wait_for(lambda: len(ros.complaints) == 2, 5, "the refusals")
    assert all("odometry of another time" in said for said in ros.complaints)
    assert state(ros).motion == 0


def test_a_velocity_from_before_a_hold_that_comes_after_its_answer_moves_nothing(owner, ros):
    drive_until(owner, lambda: ros.base.x > 0.01)
    owner.ask()  # once it is answered, what was sent before is delivered
    ros.bridge.kept_back = []
    owner.drive(AHEAD)
    owner.hold()
    assert len(ros.bridge.kept_back) == 1
    ros.bridge.deliver()
    assert (state(ros).moving, state(ros).motion) == (False, 1)
    assert "before the hold" in ros.complaints[-1]
    drive_until(owner, lambda: state(ros).motion == 2)


def test_velocities_that_overtake_each_other_end_with_the_newest(owner, ros):
    drive_until(owner, lambda: ros.base.x > 0.01)
    owner.ask()  # once it is answered, what was sent before is delivered
    ros.bridge.kept_back = []
    for velocity in (AHEAD, Velocity(0.0, 0.0)):
        at = owner.odometry.at
        owner.drive(velocity)
        owner.odometry.wait(5, after=at)
    wait_for(lambda: len(ros.bridge.kept_back) == 2, 5, "both")
    ros.bridge.deliver(order=-1)
    assert "overtaken" in ros.complaints[-1]
    wait_for(lambda: not state(ros).moving, 5, "rest")
    assert ros.base.velocity == (0.0, 0.0)


def test_ros_2_hands_on_velocities_in_their_order(ros):
    if ros.version == 2:
        assert isinstance(ros.groups["irat/drive"], Ordered)


def drive_of(odometry):
    stamp = odometry.stamp
    return {"sec": int(stamp), "nanosec": int(stamp % 1 * 1e9), "twist": AHEAD.encode()}


def test_everybody_may_hold_with_any_arguments(owner, ros):
    with connect(f"ws://{ros.bridge.address}") as stranger:
        for number, args in enumerate(([], None, {}, 5)):
            before = ros.base.x
            drive_until(owner, lambda before=before: ros.base.x > before + 0.01)
            stranger.send(json.dumps({"op": "call_service", "id": number, "service": "/irat/hold", "args": args}))
            answer = json.loads(stranger.recv(timeout=5))
            assert answer["id"] == number
            assert answer["values"] == {"success": True, "message": "at rest"}


def test_a_node_that_was_started_again_does_not_move_for_an_owner_it_does_not_know(owner, ros):
    drive_until(owner, lambda: ros.base.x > 0.01)
    ros.end_node()
    start_node(ros)
    ros.base.velocity = (0.0, 0.0)
    owner.drive(AHEAD)
    assert state(ros).motion == 0

    def restarted():
        try:
            owner.obeys()
        except ControllerRestarted:
            return True
        return False

    wait_for(restarted, 10, "the owner's error")
    owner.claim()
    drive_until(owner, lambda: state(ros).motion == 1)


@pytest.mark.parametrize("extra", [{"header": {"seq": 1}}, {"epoch": "7"}, {"epoch": None}, {"twist": None}])
def test_what_rosbridge_refuses_moves_nothing(owner, ros, extra):
    """The conversion rules are as strict as those of rosbridge_suite, so that the tests above mean something."""
    owner.bridge.publish("/irat/drive", {**drive_of(owner.odometry.value), "epoch": 7, **extra})
    wait_for(lambda: ros.bridge.said, 5, "rosbridge's complaint")
    assert state(ros).motion == 0


def test_the_whole_driver_drives_by_hand_shows_pictures_and_holds(ros, tmp_path):
    driver = Driver(f"socket://{ros.bridge.address}", {"epoch": 7, "folder": str(tmp_path)})
    try:
        state = driver.connect()
        assert state.ready and state.values["charging"] == 0.0 and state.values["battery"] == pytest.approx(7.4)

        def permit():
            if ros.base.x > 0.05:
                raise MotionHeld("That is far enough.")

        with pytest.raises(MotionHeld):
            driver.execute("drive", {"forward": 1.0, "turn": 0.2}, permit, lambda stage: None)
        assert ros.base.velocity == (0.0, 0.0), "at rest when it returns"
        assert driver.picture("camera", 5) == PICTURE
        state = driver.hold()
        assert (state.moving, driver.line.bridge.unreadable) == (False, 0)
        assert ros.bridge.said == []
    finally:
        driver.close()
