#!/usr/bin/env python3
"""The node irat for ROS 2; its rules are in rules.py."""

import contextlib
import threading
import time
from typing import Any

import rclpy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import Float32
from std_srvs.srv import Trigger

from irat.msg import Drive, State
from irat.srv import Claim, Status

from rules import MOST_HOLDS, STATE_S, STEP_S, Rules, fill, seconds, six


class IratNode(Node):
    """Passes velocities on to the base, as the rules allow."""

    def __init__(self) -> None:
        super().__init__("irat")
        speed, turn = (self.declare_parameter(name, most).value for name, most in (("speed", 0.2), ("turn", 2.5)))
        self.rules = Rules(int(time.time()), speed, turn, stamps=lambda: self.get_clock().now().nanoseconds * 1e-9)
        together, ordered = ReentrantCallbackGroup(), MutuallyExclusiveCallbackGroup()
        self.base = self.create_publisher(Twist, "base/cmd_vel", 1)
        self.state_publisher = self.create_publisher(State, "irat/state", 1)
        self.create_subscription(Drive, "irat/drive", self.drive, 1, callback_group=ordered)
        for kind, topic, heard in (
            (Odometry, "irat/odom", self.odometry), (Float32, "irat/charger_current", self.charger),
        ):  # fmt: skip
            self.create_subscription(kind, topic, heard, qos_profile_sensor_data, callback_group=together)
        for kind, service, answer in (
            (Claim, "irat/claim", self.claim), (Trigger, "irat/hold", self.hold), (Status, "irat/status", self.status),
        ):  # fmt: skip
            self.create_service(kind, service, answer, callback_group=together)
        self.create_timer(STATE_S, self.tell, callback_group=together)
        threading.Thread(target=self.run, name="base", daemon=True).start()  # callbacks may all wait

    def run(self) -> None:
        """Send the base its velocity while it moves or is held."""
        while self.context.ok():
            velocity = self.rules.velocity()
            if velocity is not None:
                twist = Twist()
                twist.linear.x, twist.angular.z = velocity
                self.base.publish(twist)
            time.sleep(STEP_S)

    def drive(self, message: Any) -> None:
        """Take a velocity."""
        why = self.rules.drive(message.epoch, seconds(message), six(message.twist))
        if why:
            self.get_logger().warning(why, throttle_duration_sec=1.0)

    def odometry(self, message: Any) -> None:
        """Take the measured velocity."""
        speed = message.twist.twist
        self.rules.odometry(speed.linear.x, speed.angular.z, seconds(message.header.stamp))

    def charger(self, message: Any) -> None:
        """Take the charger's current."""
        self.rules.charger(message.data)

    def claim(self, request: Any, response: Any) -> Any:
        """Answer a claim."""
        response.success, response.message, response.epoch = self.rules.claim(request.epoch)
        return response

    def hold(self, _: Any, response: Any) -> Any:
        """Hold; answer at rest."""
        response.success, response.message = self.rules.hold()
        return response

    def status(self, _: Any, response: Any) -> Any:
        """Answer with the state."""
        return fill(response, self.rules.state())

    def tell(self) -> None:
        """Publish the state."""
        self.state_publisher.publish(fill(State(), self.rules.state()))


def main() -> None:
    """Run the node."""
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=MOST_HOLDS + 4)
    executor.add_node(IratNode())
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        executor.spin()


if __name__ == "__main__":
    main()
