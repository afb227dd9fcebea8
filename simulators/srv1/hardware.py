"""The hardware as the rover's firmware uses it: the motor board, the sensors, the camera."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from simulators.common.faults import FaultBoard
from simulators.srv1.drive import Drive


class Hardware(Protocol):
    """All methods are called under the firmware's lock, except the picture's, which takes long."""

    @property
    def drive(self) -> Drive:
        """Return the motor board."""

    @property
    def faults(self) -> FaultBoard:
        """Return what is broken at present."""

    def infrared(self) -> float:
        """Return the distance (m) that the infrared sensor tells, from `near` to `far`."""

    def sonar(self) -> float:
        """Return the distance (m) that the sonar tells, from `near` to `far`."""

    def analogue(self, channel: int) -> int:
        """Return the counts (0 to 1023) of a channel of `robots.kit.drivers.srv1.sensors.Channel`; 0 of any other."""

    def encoders(self) -> tuple[int, int]:
        """Return the counts of the left and the right wheels since power on; they fall while a wheel turns back."""

    def compass(self) -> float:
        """Return the heading in degrees, 0 to 360, clockwise from north, which is the hall's y axis."""

    def battery(self) -> float:
        """Return the voltage (V)."""

    def picture(self, width: int) -> NDArray[np.uint8] | None:
        """Return a picture (RGB, shape (height, width, 3)) as wide as one of `SIZES`; None while the camera is busy."""

    def beacon(self) -> tuple[float, float] | None:
        """Return distance (m) from the radio tower and bearing (rad) there, anticlockwise from x; None: not heard."""
