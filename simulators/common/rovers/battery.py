"""The battery of a rover: lithium-ion cells, their charger, and the current that the robot takes."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

# the usual curve of such cells: shares of the charge, and of the way from the empty to the full voltage
CHARGE = (0.0, 0.05, 0.20, 0.50, 0.80, 1.0)
VOLTAGE = (0.0, 0.25, 0.42, 0.55, 0.75, 1.0)
FULL_A = 0.05  # the charging current below which the charger says full
TRICKLE = 0.97  # share below which a full battery is charged again


@dataclass
class Battery:
    """`charge` is the share that is left, 0 to 1. Currents in A, positive into the battery.

    `figures`: `capacity_ah`, `full` and `empty` (V), `resistance` (ohm), `idle` and `driving` (A); `charger` (A) if
    it has contacts for one.
    """

    figures: Mapping[str, float]
    charge: float = 1.0
    current: float = 0.0
    charger_current: float = 0.0
    full: bool = False

    @property
    def rest_voltage(self) -> float:
        """Return the voltage without a load (V)."""
        share = float(np.interp(self.charge, CHARGE, VOLTAGE))
        return self.figures["empty"] + share * (self.figures["full"] - self.figures["empty"])

    @property
    def voltage(self) -> float:
        """Return the voltage at the terminals (V)."""
        return self.rest_voltage + self.current * self.figures["resistance"]

    @property
    def flat(self) -> bool:
        """Return whether nothing is left."""
        return self.charge <= 0.0

    def advance(self, seconds: float, speed_share: float, contacts: bool) -> None:
        """Let time pass: driving at a share of full speed, or with the charger's contacts closed."""
        taken = self.figures["idle"] + self.figures["driving"] * min(1.0, abs(speed_share))
        self.charger_current = self._charger(taken) if contacts else 0.0
        self.full = contacts and ((self.full and self.charge > TRICKLE) or self.charger_current - taken < FULL_A)
        if self.full:
            self.charger_current = taken
        self.current = self.charger_current - taken
        change = self.current * seconds / 3600 / self.figures["capacity_ah"]
        self.charge = float(min(1.0, max(0.0, self.charge + change)))

    def _charger(self, taken: float) -> float:
        """Return the charger's current (A): its greatest, or less where the voltage would rise above full."""
        most = taken + (self.figures["full"] - self.rest_voltage) / self.figures["resistance"]
        return float(max(0.0, min(self.figures["charger"], most)))
