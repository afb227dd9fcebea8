#!/usr/bin/env python3
"""The node irat for ROS 1 (Noetic); its rules are in rules.py."""

import sys
import time
from pathlib import Path
from typing import Any

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import Float32
from std_srvs.srv import Trigger, TriggerResponse

from irat.msg import Drive, State
from irat.srv import Claim, ClaimResponse, Status, StatusResponse

sys.path.insert(0, str(Path(__file__).resolve().parent))  # catkin's devel space runs this from another folder
from rules import STATE_S, STEP_S, Rules, fill, seconds, six


class IratNode:
    """Passes velocities on to the base, as the rules allow."""

    def __init__(self) -> None:
        speed, turn = rospy.get_param("~speed", 0.2), rospy.get_param("~turn", 2.5)
        self.rules = Rules(int(time.time()), speed, turn, stamps=rospy.get_time)
        self.base = rospy.Publisher("base/cmd_vel", Twist, queue_size=1)
        self.state_publisher = rospy.Publisher("irat/state", State, queue_size=1)
        rospy.Subscriber("irat/drive", Drive, self.drive, queue_size=1)
        rospy.Subscriber("irat/odom", Odometry, self.odometry, queue_size=1)
        rospy.Subscriber("irat/charger_current", Float32, self.charger, queue_size=1)
        rospy.Service("irat/claim", Claim, self.claim)
        rospy.Service("irat/hold", Trigger, self.hold)
        rospy.Service("irat/status", Status, self.status)

    def run(self) -> None:
        """Send the base its velocity while it moves or is held, and publish the state."""
        told = 0.0
        while not rospy.is_shutdown():
            velocity = self.rules.velocity()
            if velocity is not None:
                twist = Twist()
                twist.linear.x, twist.angular.z = velocity
                self.base.publish(twist)
            if time.monotonic() - told >= STATE_S:
                told = time.monotonic()
                self.state_publisher.publish(fill(State(), self.rules.state()))
            time.sleep(STEP_S)

    def drive(self, message: Any) -> None:
        """Take a velocity."""
        why = self.rules.drive(message.epoch, seconds(message), six(message.twist))
        if why:
            rospy.logwarn_throttle(1.0, why)

    def odometry(self, message: Any) -> None:
        """Take the measured velocity."""
        speed = message.twist.twist
        self.rules.odometry(speed.linear.x, speed.angular.z, seconds(message.header.stamp))

    def charger(self, message: Any) -> None:
        """Take the charger's current."""
        self.rules.charger(message.data)

    def claim(self, request: Any) -> Any:
        """Answer a claim."""
        success, message, epoch = self.rules.claim(request.epoch)
        return ClaimResponse(success=success, message=message, epoch=epoch)

    def hold(self, _: Any) -> Any:
        """Hold; answer at rest."""
        success, message = self.rules.hold()
        return TriggerResponse(success=success, message=message)

    def status(self, _: Any) -> Any:
        """Answer with the state."""
        return StatusResponse(**self.rules.state())


if __name__ == "__main__":
    rospy.init_node("irat")
    IratNode().run()
