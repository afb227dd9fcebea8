"""The rover's sensors in the hall: each with its noise, and with the faults of the fault board."""

from math import atan2, degrees, floor, hypot, remainder, sin, tau

import numpy as np

from robots.kit.description import load
from robots.kit.drivers.srv1.hall import Hall
from robots.kit.drivers.srv1.sensors import Channel, infrared_counts, share_counts, temperature_counts
from simulators.common.faults import FaultBoard
from simulators.srv1.climate import Climate
from simulators.srv1.plant import Plant

RAYS = 9  # of the sonar's cone
GHOSTS = (0.3, 0.9), (1.1, 3.0)  # shares of the true distance: an echo from elsewhere, or none from a slanting wall
COMPASS_DEG, IRON_DEG = 0.8, 1.5  # its noise, and its deviation by the rover's own iron, which depends on the heading
BEACON_M, BEACON_RAD = 0.05, 0.02  # noise of range and bearing
SET_UP_RAD = 0.01  # standard deviation of the tower's alignment with the hall
REFLECTED, DETOUR_M = 0.02, (0.3, 2.0)  # share of readings that come by a reflection, and how much longer their way is
WARMTH_C, SHARE = 0.1, 0.004  # noise of the thermometer, and of readings that are shares from 0 to 1


class Senses:
    """Reads the plant. `advance` is called after each of its ticks."""

    def __init__(self, plant: Plant, where: Hall, faults: FaultBoard, seed: int = 1, beacon: bool = False) -> None:
        self._plant, self._hall, self._faults = plant, where, faults
        known = load("srv1")
        self._infrared, self._sonar, self._ticks = known["infrared"], known["sonar"], known["body"]["ticks"]
        self._reach = float(known["line"]["radio_m"])
        self._antenna = 0.0, 0.0, float(known["body"]["height"])
        self._dice = np.random.default_rng(seed)
        self._iron = float(self._dice.uniform(0, tau))
        self._climate = Climate(where, seed)
        self._black = frozenset(case.name for case in where.cases if case.black)
        self._has_beacon, self._set_up = beacon, SET_UP_RAD * float(np.random.default_rng([seed, 1]).standard_normal())
        self.now = 0.0
        self.power_on()

    def power_on(self) -> None:
        """Count the encoders from zero."""
        self._last, self._counts = self._plant.angles, [0.0, 0.0]

    def advance(self, now: float) -> None:
        """Count the turns of the wheels; a dead encoder (1: left, 2: right, 3: both) counts nothing."""
        self.now = now
        angles, dead = self._plant.angles, int(self._faults.value("dead_encoder"))
        for side in (0, 1):
            if not dead >> side & 1:
                self._counts[side] += (angles[side] - self._last[side]) * self._ticks / tau
        self._last = angles

    def encoders(self) -> tuple[int, int]:
        """Return the counts of the rear wheels, left and right, since power on."""
        left, right = self._counts
        return floor(left), floor(right)

    def infrared(self) -> float:
        """Return what the infrared sensor reads ahead (m): one narrow ray, which black glass does not reflect."""
        known = self._infrared
        away, name = self._plant.ray(known["from"], 0.0)
        if name in self._black or self._faults.value("blind_infrared"):
            return float(known["far"])
        return self._read(away, known)

    def sonar(self) -> float:
        """Return what the sonar reads ahead (m): the nearest surface in its cone; by a fault, now and then a ghost."""
        known = self._sonar
        half = known["half_cone"]
        away = min(self._plant.ray(known["from"], float(angle))[0] for angle in np.linspace(-half, half, RAYS))
        if self._faults.chance("sonar_ghost"):
            away *= float(self._dice.uniform(*GHOSTS[int(self._dice.integers(2))]))
        return self._read(away, known)

    def _read(self, away: float, known: dict[str, float]) -> float:
        if away >= known["far"]:
            return float(known["far"])
        noisy = away + known["noise"] * float(self._dice.standard_normal())
        return float(min(max(noisy, known["near"]), known["far"]))

    def compass(self) -> float:
        """Return the heading, clockwise from north, which is the hall's +y (degrees, 0 to 360)."""
        heading = self._plant.pose[2]
        off = IRON_DEG * sin(heading + self._iron) + COMPASS_DEG * float(self._dice.standard_normal())
        return float((90.0 - degrees(heading) + off) % 360.0)

    def beacon(self) -> tuple[float, float] | None:
        """Return where the rover is from the tower: range (m) and bearing (rad, from +x).

        None where there is no beacon, and where it is not heard: out of reach, or something stands before it.
        """
        if not self._has_beacon or self._faults.value("beacon_gone"):
            return None
        (x, y, _), (tower_x, tower_y) = self._plant.pose, self._hall.tower
        east, north = x - tower_x, y - tower_y
        if hypot(east, north) > self._reach or not self._plant.in_sight(
            self._antenna, (tower_x, tower_y, self._hall.high)
        ):
            return None
        noise = self._dice.standard_normal(2)
        away = max(0.0, hypot(east, north) + BEACON_M * float(noise[0]))
        if self._dice.random() < REFLECTED:
            away += float(self._dice.uniform(*DETOUR_M))
        return away, remainder(atan2(north, east) + self._set_up + BEACON_RAD * float(noise[1]), tau)

    def analogue(self, channel: int) -> int:
        """Return the counts (0 to 1023) of a channel; 0 of one to which nothing is connected."""
        (x, y, _), air = self._plant.pose, self._climate
        noise = float(self._dice.standard_normal())
        match channel:
            case Channel.INFRARED:
                return infrared_counts(self.infrared(), self._infrared["near"])
            case Channel.TEMPERATURE:
                return temperature_counts(air.temperature(self.now, x, y) + WARMTH_C * noise)
            case Channel.HUMIDITY:
                return share_counts(air.humidity(self.now, x, y) + SHARE * noise)
            case Channel.LIGHT:
                return share_counts(air.light(self.now, x, y) + SHARE * noise)
            case Channel.PRESENCE:
                return share_counts(air.presence(self.now, x, y) + SHARE * noise)
        return 0
