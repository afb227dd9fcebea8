"""The robot's words for what it does."""

from enum import StrEnum


class Mode(StrEnum):
    """The present activity of the robot; `RobotState.mode` tells it."""

    RESTING = "resting"
    EXPLORING = "exploring"
    GOAL = "going to somebody's goal"
    CHARGING = "charging"
    DOCKING = "going to the dock"
    STUCK = "stuck"
    HAND = "driven by hand"
    FLAT = "waiting for staff: battery"
