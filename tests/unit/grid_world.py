"""A rover in the hall that scans in place: rays by the hall's own geometry, so that the map's is judged by another one."""

from dataclasses import dataclass, replace
from math import cos, hypot, pi, sin, tau

import numpy as np

from robots.kit.description import load
from robots.kit.drivers.srv1.hall import Exhibit, Hall, hall
from robots.kit.rovers.grid import TURNS, Scan, scan_of

KNOWN = load("srv1")
TURN = tau / 18
RAYS = 9  # of the sonar's cone
GHOST = (0.3, 0.9)  # share of the true distance


@dataclass(frozen=True)
class Noise:
    """What a scan suffers: standard deviations (m, rad), shares, and the slip of the wheels while they turn."""

    share: float = 1.0  # of the sensors' noise as described
    slip: tuple[float, float] = (0.10, 0.35)  # of each turn, the same during one scan
    step: float = 0.015  # of one turn besides
    compass: float = 0.05  # of one reading: about three degrees
    bias: float = 0.035  # of all readings of a scan
    wander: float = 0.003  # of the middle, in each turn
    ghosts: float = 0.04  # share of the sonar's readings that are too short


NONE = Noise(0.0, (0.22, 0.22), 0.0, 0.0, 0.0, 0.0, 0.0)


class World:
    """The hall, perhaps with visitors whom the map does not have."""

    def __init__(self, where: Hall | None = None, visitors: tuple[tuple[float, float], ...] = ()) -> None:
        self.hall = where or hall()
        people = tuple(Exhibit("Visitor", at, 0.25, 1.7) for at in visitors)
        self.hall = replace(self.hall, exhibits=self.hall.exhibits + people)

    def place(self, dice, clearance=0.3):
        """Return a random pose that leaves so much room (m)."""
        while True:
            x, y = dice.uniform(0, self.hall.width), dice.uniform(0, self.hall.depth)
            if self.hall.distance(x, y) >= clearance:
                return float(x), float(y), float(dice.uniform(-pi, pi))

    def read(self, pose, name, half, rays):
        """Return what a sensor reads without noise (m)."""
        known, (x, y, heading) = KNOWN[name], pose
        x, y = x + known["from"][0] * cos(heading), y + known["from"][0] * sin(heading)
        away, thing = min(
            (self.hall.ray(x, y, heading + float(a)) for a in np.linspace(-half, half, rays)), key=lambda met: met[0]
        )
        swallowed = name == "infrared" and getattr(thing, "black", False)
        return known["far"] if swallowed else min(max(away, known["near"]), known["far"])

    def sonar(self, pose):
        """Return the nearest surface in the cone without noise (m)."""
        return self.read(pose, "sonar", KNOWN["sonar"]["half_cone"], RAYS)

    def infrared(self, pose):
        """Return what the narrow ray reads without noise (m)."""
        return self.read(pose, "infrared", 0.0, 1)

    def scan(self, pose, dice, noise=None, with_compass=True, count=TURNS):
        """Scan in place; return the scan and the true pose at its end."""
        noise = noise or Noise()
        x, y, heading = pose
        slip, bias = dice.uniform(*noise.slip), dice.normal() * noise.bias
        turns, compass, ranges, truly = [], [], [], []
        for number in range(count):
            if number:
                heading += (1 - slip) * TURN + dice.normal() * noise.step
                turns.append(TURN)
                x, y = x + noise.wander * dice.normal(), y + noise.wander * dice.normal()
            truly.append(heading)
            compass.append(heading + bias + noise.compass * dice.normal())
            sonar = self.sonar((x, y, heading)) * (dice.uniform(*GHOST) if dice.random() < noise.ghosts else 1.0)
            ranges.append([
                noisy(sonar, KNOWN["sonar"], noise, dice),
                noisy(self.infrared((x, y, heading)), KNOWN["infrared"], noise, dice),
            ])  # fmt: skip
        sonar, infrared = np.array(ranges).T
        if with_compass:
            return scan_of(turns, compass, sonar, infrared), (x, y, heading)
        return Scan(np.array(truly) - truly[-1], sonar, infrared), (x, y, heading)


def noisy(away, known, noise, dice):
    """Return a reading with noise, as far as the sensor reaches."""
    if away >= known["far"]:
        return known["far"]
    return float(np.clip(away + noise.share * known["noise"] * dice.normal(), known["near"], known["far"]))


def off(found, pose):
    """Return how far a pose is from another (m), and how far it is turned from it (rad)."""
    turned = (found[2] - pose[2] + pi) % tau - pi
    return hypot(found[0] - pose[0], found[1] - pose[1]), abs(turned)
