"""The sound at a microphone beside the arm: its motors while they turn, air while it blows, and a quiet room.

Each joint has a motor whose pitch and loudness follow the speed of that joint, so a diagonal motion sounds otherwise
than a straight one, and a motion swells and dies away with its ramps.
"""

from collections.abc import Callable
from math import tau

import numpy as np
from numpy.typing import NDArray

from robots.kit.drivers.mercury.scara import OutOfReach
from simulators.common.microphone import RATE
from simulators.mercury.arm import Body, Pose
from simulators.mercury.workspace import Workspace

Samples = NDArray[np.float32]
ROOM, AIR = 0.002, 0.12  # mean level, of 1
FULL = np.array([1.0, 1.6, 0.1, 2.0])  # speeds at which each motor is loudest: rad/s, rad/s, m/s, rad/s
SLOWEST_HZ = np.array([70.0, 95.0, 140.0, 120.0])  # pitch of a motor at its slowest speed
FASTEST_HZ = np.array([310.0, 420.0, 620.0, 520.0])  # and at its full speed
LOUD = np.array([0.16, 0.13, 0.10, 0.06])
OVERTONES = ((1, 1.0), (2, 0.45), (3, 0.3), (5, 0.12))
STILL = 1e-3  # a share of full speed that is not heard
EMPTY = np.zeros(4)


class ArmSound:
    """The sound of the arm for one listener; `blowing` returns whether the valve is open."""

    def __init__(self, body: Body, space: Workspace, blowing: Callable[[], bool], seed: int = 0) -> None:
        self._body, self._space, self._blowing = body, space, blowing
        self._rng = np.random.default_rng(seed)
        self._phase, self._share, self._blew = EMPTY, EMPTY, 0.0

    def hear(self, since: float, until: float, count: int) -> Samples:
        """Return `count` samples of that time (s, monotonic), with no step from those before."""
        share = self._shares(since, until)
        blows = float(self._blowing())
        ramp = np.linspace(0.0, 1.0, count, endpoint=False)
        noise = self._rng.standard_normal(count)
        level = ROOM + AIR * (self._blew + (blows - self._blew) * ramp)
        heard = noise * level + self._motors(share, ramp)
        self._share, self._blew = share, blows
        return heard.astype(np.float32)

    def _motors(self, share: NDArray[np.float64], ramp: NDArray[np.float64]) -> NDArray[np.float64]:
        if not (share.any() or self._share.any()):
            return np.zeros(len(ramp))
        shares = self._share + np.outer(ramp, share - self._share)  # (count, 4)
        turns = np.cumsum(SLOWEST_HZ + (FASTEST_HZ - SLOWEST_HZ) * shares, axis=0) / RATE
        phases = self._phase + tau * turns
        self._phase = phases[-1] % tau
        tones = sum(part * np.sin(times * phases) for times, part in OVERTONES)
        return np.asarray((tones * LOUD * np.sqrt(shares)).sum(axis=1))

    def _shares(self, since: float, until: float) -> NDArray[np.float64]:
        """Return the mean speed of each joint in that time, as a share of its full speed."""
        poses = self._body.during(since, until, 2)
        if len(poses) < 2:
            return EMPTY
        try:
            before, after = (np.array(self._space.joints(Pose(*pose))) for pose in poses)
        except OutOfReach:  # the swing reaches a little farther than the arm
            return self._share
        share = np.abs(after - before) / (until - since) / FULL
        return np.where(share > STILL, np.minimum(share, 1.0), 0.0)
