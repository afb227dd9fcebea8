"""What happened to the clocks of a machine between two readings: a step of the time of day, a sleep."""

from dataclasses import dataclass
from datetime import timedelta

LEAST = timedelta(seconds=1)  # smaller steps end nothing, and nobody notices them


@dataclass(frozen=True)
class Reading:
    """All clocks at one moment (s): since 1970, since the start of the machine with and without its sleep."""

    boot: str
    wall: float
    lasted: float
    awake: float


@dataclass(frozen=True)
class Step:
    """What happened between two looks: by how much the time of day was set, how long the machine slept or was off.

    `since_s`: how long the machine was awake since the last look, or since its start (s). What was written in that time
    may be of after the step.
    """

    shift: timedelta
    paused: timedelta
    since_s: float = 0.0

    @property
    def total(self) -> timedelta:
        """Return by how much stamps of before the step have to be moved."""
        return self.shift + self.paused


def step_between(was: Reading, now: Reading) -> Step:
    """Return what happened between two readings; steps of less than a second are none."""
    awake = now.awake - was.awake
    if was.boot != now.boot or awake < 0:  # the machine was off for an unknown time
        gap = now.wall - was.wall
        # others write from the boot on, also before this look
        moved, paused, awake = min(gap, 0.0), max(gap, 0.0), now.awake
    else:
        lasted = now.lasted - was.lasted
        moved, paused = now.wall - was.wall - lasted, lasted - awake
    least = LEAST.total_seconds()
    moved, paused = (0.0 if abs(part) < least else part for part in (moved, paused))
    return Step(timedelta(seconds=moved), timedelta(seconds=paused), awake)
