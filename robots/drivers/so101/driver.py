"""The SO-101 follower arm, and its elder the SO-100, through LeRobot."""

from robots.drivers.lerobot import LeRobotDriver


class Driver(LeRobotDriver):
    """See `robots.drivers.lerobot`."""

    described = "so101"
