"""The rules of the clearance test: which questions come, what a failure says, how long the pause is.

Pure. A failed test names one topic alone and no score: who goes through the answers one by one then learns of one
wrong answer a try at most, while the pauses double. What that makes of such a person's chances is computed in
`tests/unit/test_quiz.py`.
"""

import random
from collections.abc import Collection, Sequence
from typing import TypeVar

T = TypeVar("T")


def draw(bank: Sequence[T], seen: Collection[T], count: int, rng: random.Random) -> list[T]:
    """Return `count` questions of the bank in an order of their own; those just `seen` only where too few are left."""
    fresh = [q for q in bank if q not in seen]
    stale = [q for q in bank if q in seen]
    count = min(count, len(bank))
    drawn = rng.sample(fresh, min(count, len(fresh)))
    drawn += rng.sample(stale, count - len(drawn))
    rng.shuffle(drawn)
    return drawn


def pause_s(failures: int, first_s: float, most_s: float) -> float:
    """Return the pause after so many failures in a row, in s: it doubles each time, up to `most_s`."""
    if failures <= 0:
        return 0.0
    return min(most_s, first_s * 2.0 ** min(failures - 1, 60))


def named(wrong: Sequence[T], rng: random.Random) -> T:
    """Return the one wrongly answered question whose topic is named."""
    return rng.choice(wrong)
