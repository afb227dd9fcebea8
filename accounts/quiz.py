"""The rules of the clearance test, as pure functions: questions, hint after a failure, pause.

A failed test names one topic and no score. A person who tries all answers thus learns of at most one wrong answer in
each attempt, while the pauses double; `tests/unit/test_quiz.py` computes the chances of such a person.
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
    """Return the pause after so many failures in a row (s): it doubles each time, up to `most_s`."""
    if failures <= 0:
        return 0.0
    return min(most_s, first_s * 2.0 ** min(failures - 1, 60))


def question_of_hint(wrong: Sequence[T], rng: random.Random) -> T:
    """Return the one wrongly answered question whose topic is shown."""
    return rng.choice(wrong)
