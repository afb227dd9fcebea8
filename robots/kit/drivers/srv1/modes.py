"""The rover's words for what it is doing."""

from enum import StrEnum


class Mode(StrEnum):
    """The words of `RobotState.mode`."""

    RESTING = "resting"
    HAND = "driven by hand"
    GOING = "going to a place"
    TURNING = "turning"
    PATROL = "on patrol"
    WAITING = "waiting for a free way"
