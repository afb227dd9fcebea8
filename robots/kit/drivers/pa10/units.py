"""Converts between the wire's mm and degrees and our m and rad."""

from math import degrees, radians

from robots.kit.arms.chain import Matrix
from robots.kit.arms.pose import EULER, RPY, Six, matrix
from robots.kit.drivers.pa10.protocol import Request


def pose_of(request: Request) -> Matrix:
    """Return the pose (4 x 4) of a `k`, `K` or `l` request."""
    x, y, z, *angles = request.numbers[:6]
    a, b, c = (radians(v) for v in angles)
    return matrix((x / 1000, y / 1000, z / 1000, a, b, c), EULER if request.letter == "K" else RPY)


def pose_request(letter: str, six: Six, scale: float | None = None) -> Request:
    """Return the request for (x, y, z in m, three angles in rad)."""
    numbers = [*(v * 1000 for v in six[:3]), *(degrees(v) for v in six[3:])]
    return Request(letter, tuple(numbers if scale is None else [*numbers, scale]))


def joint_request(letter: str, q: tuple[float, ...], scale: float | None = None) -> Request:
    """Return the request for six joints (rad or rad/s)."""
    numbers = [degrees(v) for v in q]
    return Request(letter, tuple(numbers if scale is None else [*numbers, scale]))
