"""The stock firmware's motor commands, with their peculiarities (`motor_command`, `motor_set`, failsafe).

A speed is never 0, the keypad does nothing before the first `M`, and a 0 for the failsafe becomes 1.
"""

from collections.abc import Callable
from enum import Enum

from robots.kit.drivers.srv1.protocol import DURATION_S, FAILSAFE_S

BASE, STEP, MOST_BASE = 40, 3, 95  # per cent: the keypad's speed at first, and how it is changed
TURN_PER_CENT, TURN_S = 70, 0.2
KEYPAD = {
    "7": (1, -15, 15), "8": (1, 0, 0), "9": (1, 15, -15), "4": (1, -30, 30), "6": (1, 30, -30),
    "1": (-1, -30, 30), "2": (-1, 0, 0), "3": (-1, 30, -30),
}  # fmt: skip


class Pulses(Enum):
    """The state of the motors' timers since the first command to them."""

    OFF = 0
    WIDTH = 1  # pulse width: the H-bridges
    POSITION = 2  # pulses for servos


def signed(byte: int) -> int:
    """Return a byte as C's `signed char`."""
    return byte - 256 if byte > 127 else byte


def clipped(speed: int) -> int:
    """Return what the timer takes: 1 to 100 per cent, ahead or back."""
    size = min(100, max(1, abs(speed)))
    return -size if speed < 0 else size


class Motors:
    """`set_percent` gets each pair of speeds; `delay` waits, in s, and may raise."""

    def __init__(self, set_percent: Callable[[int, int], None], delay: Callable[[float], None]) -> None:
        self._set, self._delay = set_percent, delay
        self.restart()

    def restart(self) -> None:
        """Forget everything, as at power on."""
        self.pulses = Pulses.OFF
        self.base = 0
        self.failsafe: tuple[int, int] | None = None

    def _drive(self, left: int, right: int) -> None:
        if self.pulses is not Pulses.POSITION:  # pulses for servos are too short for the H-bridges
            self._set(clipped(left), clipped(right))

    def move(self, argument: Callable[[], int]) -> None:
        """Do `M`: with a duration, read nothing until its end; with 0, drive on until told otherwise."""
        if self.pulses is Pulses.OFF:
            self.pulses, self.base = Pulses.WIDTH, BASE
        left, right, duration = signed(argument()), signed(argument()), argument()
        self._drive(left, right)
        if duration:
            self._delay(duration * DURATION_S)
            self._drive(0, 0)

    def servos(self, argument: Callable[[], int]) -> None:
        """Do `S`: this rover has no servos, but the timers remember."""
        if self.pulses is Pulses.OFF:
            self.pulses = Pulses.POSITION
        argument(), argument()

    def keypad(self, letter: str) -> None:
        """Do a letter of the keypad; the caller acknowledges it, whether it did anything or not."""
        if self.pulses is not Pulses.WIDTH:
            return
        if letter in "0.":
            left = TURN_PER_CENT if letter == "." else -TURN_PER_CENT
            self._drive(left, -left)
            self._delay(TURN_S)
            self._drive(0, 0)
        elif letter == "5":
            self._drive(0, 0)
        else:
            way, left, right = KEYPAD[letter]
            self._drive(way * (self.base + left), way * (self.base + right))

    def faster(self) -> None:
        """Do `+`."""
        self.base = min(MOST_BASE, self.base + STEP)

    def slower(self) -> None:
        """Do `-`."""
        self.base = max(0, self.base - STEP)

    def set_failsafe(self, argument: Callable[[], int]) -> None:
        """Do `F`."""
        left = signed(argument()) or 1
        right = signed(argument()) or 1
        self.failsafe = left, right

    def failsafe_due(self, silent_s: float) -> float | None:
        """Return in how many s of further silence the failsafe speeds are taken; None: never."""
        return None if self.failsafe is None else FAILSAFE_S - silent_s

    def fail_safe(self) -> None:
        """Take the failsafe speeds."""
        if self.failsafe is not None and self.pulses is Pulses.WIDTH:
            self._drive(*self.failsafe)
