"""Steps of the time of day and sleeps of a machine, found from two readings of its clocks."""

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
    """The change between two readings: of the time of day (`shift`), and the sleep of the machine (`paused`).

    `since_s`: how long the machine was awake since the last reading, or since its start (s). A stamp of that time
    may be from after the step.
    """

    shift: timedelta
    paused: timedelta
    since_s: float = 0.0

    @property
    def total(self) -> timedelta:
        """Return the correction for stamps from before the step."""
        return self.shift + self.paused


def step_between(was: Reading, now: Reading) -> Step:
    """Return what happened between two readings; steps of less than a second are none."""
    awake = now.awake - was.awake
    if was.boot != now.boot or awake < 0:  # the machine was off for an unknown time
        gap = now.wall - was.wall
        # others write stamps from the boot on, also before this reading
        moved, paused, awake = min(gap, 0.0), max(gap, 0.0), now.awake
    else:
        lasted = now.lasted - was.lasted
        moved, paused = now.wall - was.wall - lasted, lasted - awake
    least = LEAST.total_seconds()
    moved, paused = (0.0 if abs(part) < least else part for part in (moved, paused))
    return Step(timedelta(seconds=moved), timedelta(seconds=paused), awake)
