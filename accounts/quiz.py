"""The rules of the clearance test, as pure functions: questions, and the pause after a failure.

A failed test names the paragraphs to read again, and no answer. A person who tries all answers thus learns which were
wrong, while the pauses double; `tests/unit/test_quiz.py` computes the chances of such a person.
"""

import random
from collections.abc import Collection, Sequence
from typing import TypeVar

T = TypeVar("T")


def draw(bank: Sequence[T], recent: Collection[T], count: int, rng: random.Random) -> list[T]:
    """Return `count` questions of the bank in random order, those of `recent` only if there are too few others."""
    fresh = [q for q in bank if q not in recent]
    stale = [q for q in bank if q in recent]
    count = min(count, len(bank))
    drawn = rng.sample(fresh, min(count, len(fresh)))
    drawn += rng.sample(stale, count - len(drawn))
    rng.shuffle(drawn)
    return drawn


def pause_s(failures: int, first_s: float, most_s: float) -> float:
    """Return the pause after so many failures in a row (s): none after the first, then it doubles, up to `most_s`."""
    if failures <= 1:
        return 0.0
    return min(most_s, first_s * 2.0 ** min(failures - 2, 60))
