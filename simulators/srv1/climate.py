"""The air, the light and the visitors of the hall: slow, seeded, and different from place to place.

Each value is a function of time and place alone, so that a simulated week can begin anywhere in it.
"""

from math import dist, exp, sin, tau

import numpy as np

from robots.kit.drivers.srv1.hall import Hall

TEMPERATURE_C, HUMIDITY, LIGHT = 20.5, 0.46, 0.25  # the last two are shares
DAY_S, VENTILATION_S, CLOUD_S = 86400.0, 4700.0, 900.0
WARM, WARM_C, WARM_M = "Reptiles", 1.6, 1.2  # its lamp warms the air around it
LAMP, LAMP_M = 0.3, 1.3  # brightness and reach of the lamp over each showcase
VISIT_S, VISITED = 75.0, 0.3  # a visit's length, and the share of the time in which there is one
NEAR_M = 4.0  # within which the detector notices somebody


class Climate:
    """The air and the light at a place (m, m) at a time (s)."""

    def __init__(self, where: Hall, seed: int = 1) -> None:
        self._hall, self._seed = where, seed
        self._phases = np.random.default_rng(seed).uniform(0, tau, 6)

    def _wave(self, now: float, period_s: float, number: int) -> float:
        return sin(tau * now / period_s + float(self._phases[number]))

    def temperature(self, now: float, x: float, y: float) -> float:
        """Return the air's temperature (deg C)."""
        lamp = next((c.at for c in self._hall.cases if c.name == WARM), None)
        warm = WARM_C * exp(-((dist((x, y), lamp) / WARM_M) ** 2)) if lamp else 0.0
        return TEMPERATURE_C + 1.1 * self._wave(now, DAY_S, 0) + 0.25 * self._wave(now, VENTILATION_S, 1) + warm

    def humidity(self, now: float, x: float, y: float) -> float:
        """Return the air's relative humidity, 0 to 1: less where the same air is warmer."""
        warmer = self.temperature(now, x, y) - TEMPERATURE_C
        return HUMIDITY + 0.025 * self._wave(now, DAY_S, 2) + 0.006 * self._wave(now, VENTILATION_S, 3) - 0.028 * warmer

    def light(self, now: float, x: float, y: float) -> float:
        """Return how bright it is, 0 to 1."""
        lamps = sum(LAMP * exp(-((dist((x, y), case.at) / LAMP_M) ** 2)) for case in self._hall.cases)
        return LIGHT * (1 + 0.12 * self._wave(now, CLOUD_S, 4) + 0.08 * self._wave(now, DAY_S, 5)) + lamps

    def presence(self, now: float, x: float, y: float) -> float:
        """Return how certain it is that somebody is near, 0 to 1."""
        visit, since = divmod(now, VISIT_S)
        dice = np.random.default_rng([self._seed, int(visit) % 2**32])
        if dice.random() >= VISITED:
            return 0.0
        things = self._hall.things
        away = dist((x, y), things[int(dice.integers(len(things)))].at)
        coming = min(1.0, since / 5, (VISIT_S - since) / 5)
        return coming * max(0.0, min(1.0, 1.4 - away / NEAR_M))
