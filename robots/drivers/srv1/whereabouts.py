"""Where the rover is in the hall, and how sure that is: by the last grid scan, then by dead reckoning. m, rad."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import cos, hypot, isfinite, remainder, sin, sqrt, tau
from pathlib import Path
from typing import Any

from robots.drivers.srv1.answers import Status
from robots.files import replace_text

STILL_M = 0.05  # so far is no way
UNKNOWN_M = 10.0  # the spread of a place that is not known
KNOWN_M = 1.0  # beyond this spread a place is called unknown
LOST_M = 0.15  # by so much it is less sure if it has driven unseen
OF_WAY, OF_TURN = 0.03, 0.04  # m lost for each metre driven, and for each radian turned: four wheels slip
JUMP_M = 1.0  # odometry that changes by more between two answers has begun anew,
FASTEST_M_S = 0.5  # or by more than it could drive meanwhile, where it was not heard for a while
UNSEEN_S = 2.0  # then it has turned as nobody knows
LARGEST = 2000  # bytes of what is stored


@dataclass(frozen=True)
class Anchor:
    """Where the rover was at a moment: by its odometry since start number `boot`, and in the hall."""

    boot: int
    odometry: tuple[float, float, float]
    hall: tuple[float, float, float]
    spread: float
    motion: int


class Whereabouts:
    """Takes each status. What is known of a start of the rover outlives its owner, in `file`.

    `spread` is the radius (m) in which it is, 95 times of 100. What slips is random, so squares of errors are added.
    """

    def __init__(self, file: Path | None = None) -> None:
        self.driven = 0.0
        self._file, self._anchor = file, _stored(file)
        self._squared = UNKNOWN_M**2
        self._last: Status | None = None

    @property
    def spread(self) -> float:
        """Return the radius (m)."""
        return min(sqrt(self._squared), UNKNOWN_M)

    @property
    def is_known(self) -> bool:
        """Tell whether the place may be shown."""
        return self._anchor is not None and self.spread <= KNOWN_M

    def pose(self, status: Status) -> tuple[float, float, float]:
        """Return the pose in the hall (m, m, rad); that of the odometry while nothing is known."""
        if self._anchor is None:
            return status.x, status.y, status.heading
        x, y, heading = self._anchor.hall
        turn = remainder(heading - self._anchor.odometry[2], tau)
        dx, dy = status.x - self._anchor.odometry[0], status.y - self._anchor.odometry[1]
        return (
            x + dx * cos(turn) - dy * sin(turn), y + dx * sin(turn) + dy * cos(turn),
            remainder(status.heading + turn, tau),
        )  # fmt: skip

    def found(self, pose: tuple[float, float, float], spread: float, status: Status) -> None:
        """Take over where a scan has found the rover, as of this status."""
        self._anchor = Anchor(status.boot, (status.x, status.y, status.heading), pose, spread, status.motion)
        self._squared = spread**2
        self.keep(status)

    def take(self, status: Status) -> None:
        """Take the next status."""
        last, self._last = self._last, status
        if last is None:
            self._begin(status)
        elif last.boot != status.boot or status.dead_encoders:
            self._anchor, self._squared = None, UNKNOWN_M**2
        else:
            self._add(last, status)

    def _begin(self, status: Status) -> None:
        anchor = self._anchor
        if anchor is None or anchor.boot != status.boot or status.dead_encoders:
            self._anchor, self._squared = None, UNKNOWN_M**2
            return
        way = hypot(status.x - anchor.odometry[0], status.y - anchor.odometry[1])
        unseen = LOST_M + OF_WAY * way if status.motion != anchor.motion else 0.0
        self._squared = (anchor.spread + unseen) ** 2

    def _add(self, last: Status, status: Status) -> None:
        way = hypot(status.x - last.x, status.y - last.y)
        seconds = (status.uptime_ms - last.uptime_ms) / 1000
        if seconds < 0 or way > JUMP_M + FASTEST_M_S * seconds:
            self._anchor, self._squared = None, UNKNOWN_M**2
            return
        self.driven += way
        turn = abs(remainder(status.heading - last.heading, tau))
        lost = OF_WAY * way + OF_TURN * turn + (LOST_M if seconds > UNSEEN_S and way > STILL_M else 0.0)
        self._squared += lost * (0.6 * self.spread + lost)  # partly the same error again, as a compass that is off

    def keep(self, status: Status) -> None:
        """Store what is known, for the next owner; a disk that is full costs a scan later."""
        if self._file is None or self._anchor is None or not self.is_known:
            return
        here = (status.x, status.y, status.heading)
        known = Anchor(status.boot, here, self.pose(status), self.spread, status.motion)
        try:
            replace_text(self._file, json.dumps(asdict(known)))
        except OSError:
            return


def _stored(file: Path | None) -> Anchor | None:
    """Return what an owner before has stored; None where there is none, or it cannot be read."""
    if file is None:
        return None
    try:
        with file.open("rb") as opened:
            told: Mapping[str, Any] = json.loads(opened.read(LARGEST))
        odometry, hall = (_three(told[name]) for name in ("odometry", "hall"))
        spread = float(told["spread"])
        if not isfinite(spread):
            return None
        return Anchor(int(told["boot"]), odometry, hall, spread, int(told["motion"]))
    except (OSError, ValueError, TypeError, KeyError):
        return None


def _three(values: Any) -> tuple[float, float, float]:
    x, y, heading = map(float, values)
    if not all(map(isfinite, (x, y, heading))):
        raise ValueError("a pose is finite")
    return x, y, heading
