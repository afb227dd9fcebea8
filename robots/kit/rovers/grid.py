"""Grid scanning (section 7.2): the rover pauses, scans in place and tells where it is on the stored map, then goes.

Pure. The hall is cut into cells (`gridmap.range_map`), the belief is a histogram over x, y and heading
(`gridmap.belief`), and the likeliest cells are refined to poses between them (`gridmap.refine`). The result says how
sure it is, and is called unknown if it is not (`gridmap.estimate`).
"""

from dataclasses import dataclass
from typing import Literal

from robots.kit.rovers.gridmap.beacon import Beacon, beacon_of, with_beacon
from robots.kit.rovers.gridmap.belief import Belief, Pose
from robots.kit.rovers.gridmap.estimate import Estimate, by_beacon, by_fits
from robots.kit.rovers.gridmap.plan import Plan, RangeSensor
from robots.kit.rovers.gridmap.range_map import RangeMap
from robots.kit.rovers.gridmap.refine import fits
from robots.kit.rovers.gridmap.scan import TURNS, Scan, scan_of

__all__ = [
    "SCANS", "TURNS", "Beacon", "Belief", "Estimate", "Fix", "Plan", "Pose", "RangeMap", "RangeSensor", "Scan",
    "beacon_of", "by_beacon", "locate", "next_step", "scan_of", "with_beacon",
]  # fmt: skip

CANDIDATES = 24  # cells that are refined
SCANS = 3  # a first one, and twice again; then somebody is asked


@dataclass(frozen=True)
class Fix:
    """An estimate, and the belief in cells after the scan, with which the next scan begins."""

    estimate: Estimate
    belief: Belief


def locate(belief: Belief, scan: Scan, beacon: Beacon | None = None) -> Fix:
    """Return the pose of a rover that has just scanned, as of the last reading; `belief` is its belief before.

    If the map explains the scan in no place that agrees with the beacon, the hall has changed: then the place is that
    of the beacon, and the heading that of the compass. A beacon that has the rover outside the map is ignored.
    """
    if beacon is not None and not belief.ranges.plan.holds(*beacon.place):
        beacon = None
    before = belief if beacon is None else with_beacon(belief, beacon)
    after = before.after_scan(scan)
    found = fits(belief.ranges, after.peaks(CANDIDATES)[0], scan, beacon)
    estimate = by_fits(found, belief)
    if beacon is None or scan.heading is None or (estimate.is_known and beacon.agrees(*estimate.pose[:2])):
        return Fix(estimate, after)
    return Fix(by_beacon(beacon, scan.heading, scan.heading_spread), before)


def next_step(estimate: Estimate, scans: int) -> Literal["go", "scan", "ask"]:
    """Return what to do after so many scans in turn: an unknown pose is scanned twice again, then somebody is asked."""
    return "go" if estimate.is_known else "scan" if scans < SCANS else "ask"
