"""The SO-101 follower arm and its predecessor, the SO-100, through LeRobot."""

from robots.kit.drivers.lerobot import LeRobotDriver


class Driver(LeRobotDriver):
    """A `robots.kit.drivers.lerobot.LeRobotDriver`."""

    described = "so101"
