"""The pace of the machine beside a figure: how much slower a fixed work and short sleeps are than nominal.

1.0 is what a free core with Python 3.11 took in 2026; 2.0 is twice as long, by a slower machine or a busy one.
"""

from robots.kit.clock import TIMER, Timer  # noqa: TID251 - of the machine, beside figures of proofs

LOOPS, ROUNDS = 1_000_000, 5
NOMINAL_S = 0.050  # for one round of so many loops
NAPS, NAP_S = 50, 0.010


def work(clock: Timer) -> float:
    """Return how long a fixed small work takes on the processor and in line for it, as a ratio to nominal."""
    begun = clock.monotonic()
    for _ in range(ROUNDS):
        total = 0
        for i in range(LOOPS):
            total += i * i
    return (clock.monotonic() - begun) / (ROUNDS * NOMINAL_S)


def naps(clock: Timer) -> float:
    """Return how long short sleeps take, as a ratio to what was asked for."""
    begun = clock.monotonic()
    for _ in range(NAPS):
        clock.sleep(NAP_S)
    return (clock.monotonic() - begun) / (NAPS * NAP_S)


def measured(clock: Timer = TIMER) -> dict[str, float]:
    """Return both; takes a second."""
    return {"work": round(work(clock), 2), "sleep": round(naps(clock), 2)}
