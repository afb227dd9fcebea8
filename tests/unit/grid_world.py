"""A hall for the grid scan with rays of its own: the map's geometry is judged by another one, that of the rover's ways."""

from dataclasses import dataclass, field
from math import cos, hypot, pi, sin, tau

import numpy as np

from robots.autonomy.grid import TURNS, Scan, scan_of
from robots.description import load
from robots.drivers.srv1.ways import room

KNOWN = load("srv1")
HALL = KNOWN["hall"]
TURN = tau / 18
RAYS = 9  # of the sonar's cone


@dataclass
class Noise:
    """What a scan suffers: standard deviations (m, rad) and shares."""

    share: float = 1.0  # of the sensors' noise as described
    slip: tuple[float, float] = (0.10, 0.35)  # of a turn
    step: float = 0.015  # of one turn besides
    compass: float = 0.05  # of one reading: about three degrees
    bias: float = 0.035  # of all readings of a scan
    wander: float = 0.003  # of the middle while it turns, each turn
    ghosts: float = 0.04  # share of the sonar's readings that are too short


NONE = Noise(0.0, (0.22, 0.22), 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass
class World:
    """The hall, perhaps with what the map does not have: visitors as circles (x, y, radius)."""

    visitors: list[tuple[float, float, float]] = field(default_factory=list)
    hall: dict = field(default_factory=lambda: HALL)

    def away(self, x, y):
        """Return how far the nearest surface is (m), and whether it swallows infrared light."""
        black = [c for c in self.hall.get("case", ()) if c.get("black")]
        near = room((x, y), self.hall)
        near = min([near, *(hypot(x - a, y - b) - r for a, b, r in self.visitors)])
        dark = any(near > room((x, y), {"width": 1e9, "depth": 1e9, "case": [c]}) - 1e-6 for c in black if x > 0 < y)
        return near, dark

    def ray(self, x, y, angle, far):
        """Follow a ray as far as nothing is near (m); tell what it ends at."""
        gone, dark = 0.0, False
        while gone < far:
            near, dark = self.away(x + gone * cos(angle), y + gone * sin(angle))
            if near < 1e-4:
                return gone, dark
            gone += near
        return far, False

    def sonar(self, pose):
        """Return the nearest surface in the cone without noise (m)."""
        x, y, heading = pose
        known = KNOWN["sonar"]
        x, y = x + known["from"][0] * cos(heading), y + known["from"][0] * sin(heading)
        half, best = known["half_cone"], known["far"]
        for angle in np.linspace(-half, half, RAYS):
            best = min(best, self.ray(x, y, heading + angle, best)[0])
        return max(best, known["near"])

    def infrared(self, pose):
        """Return what the narrow ray reads without noise (m)."""
        x, y, heading = pose
        known = KNOWN["infrared"]
        x, y = x + known["from"][0] * cos(heading), y + known["from"][0] * sin(heading)
        gone, dark = self.ray(x, y, heading, known["far"])
        return known["far"] if dark else max(gone, known["near"])

    def scan(self, pose, dice, noise=None, with_compass=True, count=TURNS):
        """Scan in place; return the scan and the true pose at its end."""
        noise = noise or Noise()
        x, y, heading = pose
        slip, bias = dice.uniform(*noise.slip), dice.normal(0, 1) * noise.bias
        turns, compass, sonar, infrared, truly = [], [], [], [], []
        for number in range(count):
            if number:
                turned = (1 - slip) * TURN + dice.normal(0, 1) * noise.step
                heading += turned
                turns.append(TURN)
                x, y = (np.array([x, y]) + noise.wander * dice.normal(0, 1, 2)).tolist()
            truly.append(heading)
            compass.append(heading + bias + noise.compass * dice.normal(0, 1))
            read = self.sonar((x, y, heading))
            if dice.random() < noise.ghosts:
                read *= dice.uniform(0.3, 0.9)
            sonar.append(_read(read, KNOWN["sonar"], noise, dice))
            infrared.append(_read(self.infrared((x, y, heading)), KNOWN["infrared"], noise, dice))
        if with_compass:
            return scan_of(turns, compass, sonar, infrared), (x, y, heading)
        turned = np.array(truly) - truly[-1]
        return Scan(turned, np.array(sonar), np.array(infrared)), (x, y, heading)

    def place(self, dice, clearance=0.3):
        """Return a random pose that leaves so much room (m)."""
        while True:
            x, y = dice.uniform(0, self.hall["width"]), dice.uniform(0, self.hall["depth"])
            if self.away(x, y)[0] >= clearance:
                return float(x), float(y), float(dice.uniform(-pi, pi))


def _read(away, known, noise, dice):
    if away >= known["far"]:
        return known["far"]
    return float(np.clip(away + noise.share * known["noise"] * dice.normal(0, 1), known["near"], known["far"]))
