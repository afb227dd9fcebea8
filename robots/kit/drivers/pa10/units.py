"""Converts between the wire's mm and degrees and our m and rad."""

from math import degrees, radians

from robots.kit.arms.chain import Matrix
from robots.kit.arms.motions import Motion, Pause, Step
from robots.kit.arms.pose import EULER, RPY, Six, matrix
from robots.kit.drivers.pa10.protocol import MOTIONS, Request

GRIP_S = 1.0  # what a step with the gripper takes in a plan


def motion_of(request: Request) -> Motion:
    """Return the motion of a `j`, `k`, `K` or `l` request."""
    scale = request.numbers[6] if len(request.numbers) > 6 else None
    if request.letter == "j":
        return Motion(tuple(radians(v) for v in request.numbers[:6]), scale=scale)
    angles = EULER if request.letter == "K" else RPY
    return Motion(pose=_six(request), angles=angles, straight=request.letter == "l", scale=scale)


def step_of(request: Request) -> Step:
    """Return the step of a program; one without motion is a pause."""
    if request.letter in MOTIONS:
        return motion_of(request)
    if request.letter == "d":
        return Pause(request.numbers[0])
    return Pause(GRIP_S if request.letter == "g" else 0.0)


def _six(request: Request) -> Six:
    x, y, z, *angles = request.numbers[:6]
    a, b, c = (radians(v) for v in angles)
    return x / 1000, y / 1000, z / 1000, a, b, c


def pose_of(request: Request) -> Matrix:
    """Return the pose (4 x 4) of a `k`, `K` or `l` request."""
    return matrix(_six(request), EULER if request.letter == "K" else RPY)


def motion_request(motion: Motion) -> Request:
    """Return the request for a motion, whose pose has its angles as RPY."""
    if motion.pose is None:
        return joint_request("j", motion.joints, motion.scale)
    return pose_request("l" if motion.straight else "k", motion.pose, motion.scale)


def pose_request(letter: str, six: Six, scale: float | None = None) -> Request:
    """Return the request for (x, y, z in m, three angles in rad)."""
    numbers = [*(v * 1000 for v in six[:3]), *(degrees(v) for v in six[3:])]
    return Request(letter, tuple(numbers if scale is None else [*numbers, scale]))


def joint_request(letter: str, q: tuple[float, ...], scale: float | None = None) -> Request:
    """Return the request for six joints (rad or rad/s)."""
    numbers = [degrees(v) for v in q]
    return Request(letter, tuple(numbers if scale is None else [*numbers, scale]))
