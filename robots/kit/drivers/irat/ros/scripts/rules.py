"""The rules of the node, without ROS: its client, the time for which it may drive, and when it rests.

A node behind rosbridge_server sees no connections, so each velocity bears the epoch of its owner. Runs with Python 3.8
(ROS 1 Noetic) and later, with the standard library alone. Thread safe, because callbacks of ROS run in several threads.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from math import isfinite
from typing import Any

LARGEST_EPOCH = 2**53 - 1
FORGET_S = 0.25  # a velocity that is not said again
LATE_S = 0.5  # a velocity that answers to older odometry is refused
REST_S = 2.0  # the longest that a hold may take
STEP_S, STATE_S = 0.02, 0.1
STILL_M_S, STILL_RAD_S, STILL = 0.01, 0.05, 3  # at rest: so slow in so many messages of the odometry
STALLED_SHARE, STALLED_S = 0.25, 0.3  # slower than this share of what it is told, for so long
MOST_HOLDS = 4  # that wait for rest at the same time; ROS 2 has few threads for callbacks
LOOK_S = 0.005
REST = (0.0, 0.0)


class Rules:
    """`boot` differs at each start; `speed` (m/s) and `turn` (rad/s) are the largest that are taken.

    `stamps` is the clock (s) by which the odometry is stamped.
    """

    def __init__(
        self, boot: int, speed: float = 0.2, turn: float = 2.5, clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep, stamps: Callable[[], float] = time.time,
    ) -> None:  # fmt: skip
        self._boot, self._speed, self._turn, self._clock, self._sleep = boot, speed, turn, clock, sleep
        self._stamps = stamps
        self._lock = threading.Lock()
        self._began = clock()
        self._epoch = self._motion = self._still = self._holds = 0
        self._end = "none"
        self._wanted, self._said = REST, 0.0
        self._braked = self._answered = self._measured = 0.0  # stamps: of the brake, the newest velocity, the odometry
        self._moving = self._holding = False
        self._slow_since: float | None = None
        self._charging = False

    def claim(self, epoch: int) -> tuple[bool, str, int]:
        """Make an epoch the commander's; return success, a sentence, and the commander's epoch.

        An epoch is never forgotten while the node runs. The same one again is the same owner on another connection.
        """
        with self._lock:
            if not 1 <= epoch <= LARGEST_EPOCH:
                return False, f"an epoch is from 1 to {LARGEST_EPOCH}", self._epoch
            if epoch < self._epoch:
                return False, f"epoch {epoch} is over; {self._epoch} has commanded since", self._epoch
            if epoch > self._epoch and self._moving:
                self._brake("replaced")
            self._epoch = epoch
            return True, "you command", epoch

    def drive(self, epoch: int, stamp: float, velocity: tuple[float, ...]) -> str:
        """Take a velocity; return why it is refused, in one sentence, or an empty text.

        `stamp`: of the odometry that it answers to (s); `velocity`: linear x, y, z (m/s) and angular x, y, z (rad/s).
        """
        with self._lock:
            self._forget()
            why = self._why_not(epoch, stamp, velocity)
            if why:
                return why
            before, self._wanted = self._wanted, (velocity[0], velocity[5])
            self._said, self._answered = self._clock(), stamp
            if self._wanted != REST and not self._moving:
                self._moving, self._motion = True, self._motion + 1
            if self._wanted != before:
                self._still = 0
            if self._moving:
                self._end = "none"
            return ""

    def _why_not(self, epoch: int, stamp: float, velocity: tuple[float, ...]) -> str:
        x, y, z, roll, pitch, yaw = velocity
        late_s = self._stamps() - stamp  # read under the lock: a thread that waited here is late, too
        if not self._epoch or epoch != self._epoch:
            return f"epoch {epoch} does not command; {self._epoch} does"
        if not abs(late_s) <= LATE_S:
            return f"this velocity answers to odometry of another time, {late_s:.1f} s ago"
        if not all(map(isfinite, velocity)) or any((y, z, roll, pitch)):
            return "linear.x and angular.z must be finite, and all others 0"
        if not (abs(x) <= self._speed and abs(yaw) <= self._turn):
            return f"at most {self._speed:g} m/s and {self._turn:g} rad/s, not {x:g} and {yaw:g}"
        if self._holding:
            return "the robot is being held; wait for the hold's answer"
        # older by more than that it would be late, unless the clock of the stamps was set back
        if 0 <= self._braked - stamp <= 2 * LATE_S:
            return "this velocity answers to odometry from before the hold"
        if 0 < self._answered - stamp <= 2 * LATE_S:
            return "this velocity was overtaken by one that answers to newer odometry"
        return ""

    def odometry(self, linear: float, angular: float, stamp: float) -> None:
        """Take a measured velocity (m/s, rad/s), by which rest and stalls are found, and its stamp (s)."""
        with self._lock:
            self._forget()
            self._measured = stamp
            slow = abs(linear) < STILL_M_S and abs(angular) < STILL_RAD_S  # NaN is not
            self._still = self._still + 1 if slow and self._wanted == REST else 0
            if self._still >= STILL and (self._moving or self._holding):
                self._moving = self._holding = False
                self._end = "done" if self._end == "none" else self._end
            self._watch(linear, angular)

    def _watch(self, linear: float, angular: float) -> None:
        x, yaw = self._wanted
        driven = abs(x) > STILL_M_S and not abs(linear) >= STALLED_SHARE * abs(x)
        turned = abs(yaw) > STILL_RAD_S and not abs(angular) >= STALLED_SHARE * abs(yaw)
        if not (driven or turned):
            self._slow_since = None
        elif self._slow_since is None:
            self._slow_since = self._clock()

    def charger(self, current: float) -> None:
        """Take the charger's current (A)."""
        with self._lock:
            self._charging = current > 0.0

    def velocity(self) -> tuple[float, float] | None:
        """Return the velocity (m/s, rad/s) that the base is to have now, None where it rests and nobody holds it."""
        with self._lock:
            self._forget()
            return self._wanted if self._moving or self._holding else None

    def _forget(self) -> None:
        if self._wanted != REST and not self._clock() - self._said <= FORGET_S:
            self._wanted, self._end, self._still = REST, "silence", 0

    def _brake(self, end: str) -> None:
        self._end = end if self._moving else self._end
        self._wanted, self._holding, self._still = REST, True, 0
        self._braked = max(self._stamps(), self._measured)  # the base's clock may be ahead

    def hold(self) -> tuple[bool, str]:
        """Brake, and wait until the odometry says rest; return success and a sentence. Everybody may."""
        with self._lock:
            self._brake("held")
            if self._holds >= MOST_HOLDS:
                return False, f"{MOST_HOLDS} holds wait for their answers already; the robot is being held"
            self._holds += 1
        try:
            until = self._clock() + REST_S
            while self._holding and self._clock() < until:
                self._sleep(LOOK_S)
            if self._holding:
                return False, f"the odometry does not say rest {REST_S:g} s after the hold"
            return True, "at rest"
        finally:
            with self._lock:
                self._holds -= 1

    def state(self) -> dict[str, Any]:
        """Return the fields of irat/State, and of the answer of irat/Status."""
        with self._lock:
            self._forget()
            now = self._clock()
            return {
                "boot": self._boot, "motion": self._motion, "end": self._end, "moving": self._moving,
                "holding": self._holding, "charging": self._charging, "epoch": self._epoch,
                "stalled": self._slow_since is not None and now - self._slow_since > STALLED_S,
                "seconds": now - self._began,
            }  # fmt: skip


def seconds(stamp: Any) -> float:
    """Return a stamp of ROS 1 or ROS 2, or of an irat/Drive, in s."""
    whole, rest = (stamp.secs, stamp.nsecs) if hasattr(stamp, "secs") else (stamp.sec, stamp.nanosec)
    return float(whole + rest * 1e-9)


def six(twist: Any) -> tuple[float, ...]:
    """Return the numbers of a geometry_msgs/Twist."""
    linear, angular = twist.linear, twist.angular
    return linear.x, linear.y, linear.z, angular.x, angular.y, angular.z


def fill(message: Any, fields: dict[str, Any]) -> Any:
    """Return the message with these fields."""
    for name, value in fields.items():
        setattr(message, name, value)
    return message
