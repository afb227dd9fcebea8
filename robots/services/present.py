"""The robot's present state as its owner stored it last; checks of requests begin there."""

from datetime import datetime, timedelta

from robots.kit.contract.session import RobotState
from robots.models import Lease, Robot

FRESH = timedelta(seconds=60)  # an older state is not used
LATER = timedelta(seconds=2)  # a state must be so much newer than a motion: it may be older than its row


def present_state(robot: Robot, lease: Lease | None, now: datetime) -> RobotState | None:
    """Return the robot's newest state from the row of its lease; None where it is old or not whole.

    Its `at` is not on any clock that is known here.
    """
    if lease is None or lease.state_at is None or now - lease.state_at > FRESH:
        return None
    told, spec = lease.state, robot.spec()
    joints, pose = tuple(told.get("joints") or ()), tuple(told.get("pose") or ())
    if len(joints) != len(spec.joints) or len(pose) != (len(spec.pose.coordinates) if spec.pose else 0):
        return None
    moving, ready = bool(told.get("moving")), bool(told.get("ready"))
    return RobotState(0.0, joints, pose, moving, ready, values=told.get("values") or {})


def state_at_rest(
    robot: Robot, lease: Lease | None, now: datetime, since: datetime, waiting: int
) -> RobotState | None:  # fmt: skip
    """Return the same where it is still true when the next command begins; None where something moves until then.

    `since` is when the last motion ended, `waiting` how many commands have not.
    """
    state = present_state(robot, lease, now)
    if state is None or state.moving or waiting or lease is None or lease.state_at is None:
        return None
    return state if lease.state_at >= since + LATER else None
