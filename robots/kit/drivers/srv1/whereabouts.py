"""The rover's place in the hall and its spread (uncertainty): by the last grid scan, then by dead reckoning. m, rad.

The spread grows with each metre and each turn, and faster beside things that the rover may touch, where wheels slide.
It also grows with each sonar reading that contradicts the map, because somebody carried the rover away or moved
something.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import cos, hypot, isfinite, remainder, sin, sqrt, tau
from pathlib import Path
from typing import Any

from robots.kit.description import load
from robots.kit.drivers.srv1.answers import Status
from robots.kit.drivers.srv1.hall import hall
from robots.kit.files import replace_text

STILL_M = 0.05  # a shorter way counts as none
UNKNOWN_M = 10.0  # the spread of a place that is not known
KNOWN_M = 1.0  # beyond this spread a place is called unknown
LOST_M = 0.15  # that the spread grows after driving unseen, beside OF_WAY of the longest way that it may have driven
OF_WAY, OF_TURN = 0.03, 0.04  # m that the spread grows for each metre and each radian: four wheels slip
BESIDE_M, OF_WAY_BESIDE = 0.25, 0.25  # nearer to something than this it may slide along it
DOUBT_M = 0.01  # that each contradiction of the map adds, and each agreement takes away
TOLERANCE_M, OF_RANGE = 0.3, 0.1  # tolerance of a range (m, and share of it), beside twice the spread
RAYS = (-1.0, -0.5, 0.0, 0.5, 1.0)  # of the half cone
JUMP_M = 1.0  # odometry that changes by more between two answers has begun anew,
FASTEST_M_S = 0.5  # or by more than it could drive meanwhile, where it was not heard for a while
UNSEEN_S = 2.0  # after a longer gap its turns are unknown
LONGEST_UNSEEN_S = float(load("srv1")["line"]["longest_permit_s"])  # it does not drive longer without a message
LARGEST = 2000  # bytes of what is stored


@dataclass(frozen=True)
class Anchor:
    """The place of the rover at a moment: by its odometry since start number `boot`, and in the hall."""

    boot: int
    odometry: tuple[float, float, float]
    hall: tuple[float, float, float]
    spread: float
    motion: int
    uptime_ms: int


class Whereabouts:
    """Takes each status. The place in a start of the rover outlives its owner, in `file`.

    `spread` is the radius (m) that contains it with 95 %. Slip is random, so squares of errors are added.
    """

    def __init__(self, file: Path | None = None) -> None:
        self.driven = 0.0
        self._file, self._anchor = file, _stored(file)
        self._squared = UNKNOWN_M**2
        self._doubt = 0.0  # m, by sonar
        self._last: Status | None = None

    @property
    def spread(self) -> float:
        """Return the radius (m)."""
        return min(sqrt(self._squared) + self._doubt, UNKNOWN_M)

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

    def take_scan(self, pose: tuple[float, float, float], spread: float, status: Status) -> None:
        """Take the place that a scan has estimated, as of this status."""
        self._anchor = Anchor(
            status.boot, (status.x, status.y, status.heading), pose, spread, status.motion, status.uptime_ms
        )
        self._squared, self._doubt = spread**2, 0.0
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
        if self.is_known and status.beacon is None:  # with a beacon the hall may be another than on the map
            self._compare(status)

    def _compare(self, status: Status) -> None:
        """Grow the spread where sonar and map contradict each other, unless somebody stands before the rover."""
        expected = sonar_at(self.pose(status))
        off, bound = status.sonar - expected, TOLERANCE_M + OF_RANGE * expected + 2 * self.spread
        if abs(off) <= bound:
            self._doubt = max(self._doubt - DOUBT_M, 0.0)
        elif off > 0 or not status.presence:
            self._doubt += DOUBT_M

    def _begin(self, status: Status) -> None:
        anchor = self._anchor
        if anchor is None or anchor.boot != status.boot or status.dead_encoders:
            self._anchor, self._squared = None, UNKNOWN_M**2
            return
        unseen = _unseen((status.uptime_ms - anchor.uptime_ms) / 1000) if status.motion != anchor.motion else 0.0
        self._squared = (anchor.spread + unseen) ** 2

    def _add(self, last: Status, status: Status) -> None:
        way = hypot(status.x - last.x, status.y - last.y)
        seconds = (status.uptime_ms - last.uptime_ms) / 1000
        if seconds < 0 or way > JUMP_M + FASTEST_M_S * seconds:
            self._anchor, self._squared = None, UNKNOWN_M**2
            return
        self.driven += way
        turn = abs(remainder(status.heading - last.heading, tau))
        share = OF_WAY if hall().distance(*self.pose(status)[:2]) > BESIDE_M else OF_WAY_BESIDE
        lost = share * way + OF_TURN * turn
        if seconds > UNSEEN_S and (way > STILL_M or last.moving or status.motion != last.motion):
            lost += _unseen(seconds)
        self._squared += lost * (0.6 * self.spread + lost)  # partly the same error again, as that of the compass

    def keep(self, status: Status) -> None:
        """Store the place for the next owner; if the disk is full, that one has to scan."""
        if self._file is None or self._anchor is None or not self.is_known:
            return
        here = (status.x, status.y, status.heading)
        known = Anchor(status.boot, here, self.pose(status), self.spread, status.motion, status.uptime_ms)
        try:
            replace_text(self._file, json.dumps(asdict(known)))
        except OSError:
            return


def _unseen(seconds: float) -> float:
    """Return how much the spread grows (m) after the rover drove unseen for at most so long, in any direction."""
    return LOST_M + OF_WAY * FASTEST_M_S * min(max(seconds, 0.0), LONGEST_UNSEEN_S)


def sonar_at(pose: tuple[float, float, float]) -> float:
    """Return what sonar would measure at a pose by the map (m): the nearest of a few rays of its cone."""
    x, y, heading = pose
    sonar = load("srv1")["sonar"]
    ahead = sonar["from"][0]
    x, y = x + ahead * cos(heading), y + ahead * sin(heading)
    nearest = min(hall().ray(x, y, heading + sonar["half_cone"] * ray)[0] for ray in RAYS)
    return float(min(max(nearest, sonar["near"]), sonar["far"]))


def _stored(file: Path | None) -> Anchor | None:
    """Return the place that an earlier owner has stored; None if there is none, or it cannot be read."""
    if file is None:
        return None
    try:
        with file.open("rb") as opened:
            told: Mapping[str, Any] = json.loads(opened.read(LARGEST))
        odometry, hall = (_three(told[name]) for name in ("odometry", "hall"))
        spread = float(told["spread"])
        if not isfinite(spread):
            return None
        return Anchor(int(told["boot"]), odometry, hall, spread, int(told["motion"]), int(told["uptime_ms"]))
    except (OSError, ValueError, TypeError, KeyError):
        return None


def _three(values: Any) -> tuple[float, float, float]:
    x, y, heading = map(float, values)
    if not all(map(isfinite, (x, y, heading))):
        raise ValueError("a pose is finite")
    return x, y, heading
