"""What the fuzzers of the robots' wires share: wild numbers, and what a simulator must never do."""

import math
from itertools import pairwise

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

WILD = (
    math.nan, math.inf, -math.inf, 1e308, -1e308, 1e30, -1e30, 3.4e38, 1e10, -1e10, 1e4, -1e4, 2**31, 2**63,
    1e-30, -1e-30, 5e-324, -0.0, 0.0, 360.0, 361.0, -360.0, 180.0, -180.0, 1.0, -1.0,
)  # fmt: skip


def weighted(*choices: tuple[int, st.SearchStrategy]) -> st.SearchStrategy:
    """Return one of the strategies, each as often as its weight says (`one_of` takes equal ones for one)."""
    shares = [strategy for weight, strategy in choices for _ in range(weight)]
    return st.integers(0, len(shares) - 1).flatmap(lambda i: shares[i])


def numbers() -> st.SearchStrategy:
    """Return numbers of all sorts, wild ones more often than others."""
    return weighted((2, st.sampled_from(WILD)), (1, st.floats()))


def rounds(number: int) -> settings:
    """Return settings for so many examples against one living simulator: nothing is shrunk, each runs once.

    Give the test a `hypothesis.seed` beside them, so that it can be repeated.
    """
    return settings(
        max_examples=number, deadline=None, derandomize=False, database=None, phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip


class Watched:
    """A simulator under fuzz: its process, its threads and its journal.

    `sim` has `process` (a Popen), `status()` with the names of its threads, and `count(event)`.
    """

    def __init__(self, sim) -> None:
        self.sim, self.pid = sim, sim.process.pid
        self.threads = self._lasting()
        self.tried = self.unanswered = 0

    def _lasting(self) -> set[str]:
        """Return the threads that serve as long as the process lives; those of single requests come and go."""
        return {name for name in self.sim.status()["threads"] if not name.startswith(("Thread-", "sand"))}

    @property
    def exits(self) -> int:
        return int(self.sim.process.poll() is not None)

    def assert_well(self) -> None:
        """Fail unless the process and its threads live and no limit was passed."""
        assert not self.exits, "the simulator ended"
        assert self.sim.process.pid == self.pid
        assert self._lasting() >= self.threads, "a thread is gone"
        assert self.sim.count("thread_died") == 0
        assert self.sim.count("passed") == 0, "a limit was passed"
        assert self.unanswered == 0

    def figure(self) -> str:
        return f"{self.tried} inputs tried, {self.exits} exits, {self.sim.count('thread_died')} dead threads, {self.unanswered} unanswered, {self.sim.count('passed')} limits passed"


def pieces(data: bytes, cuts: list[int]) -> list[bytes]:
    """Return the bytes cut at the given places."""
    places = sorted({0, len(data), *(c % (len(data) + 1) for c in cuts)})
    return [data[a:b] for a, b in pairwise(places)]


def play_rounds(fuzz, part: int, number: int, a_round: int, every: int, of: st.SearchStrategy) -> None:
    """Play so many inputs in rounds against one simulator, calibrated anew `every` so many rounds, and judge it.

    Between two calibrations what moves is seldom reset. `part` is the seed, `of` makes a round.
    """

    @seed(part)
    @rounds(number // a_round)
    @given(of, st.lists(st.integers(0, 2000), max_size=3))
    def play(items, cuts):
        if fuzz.tried // a_round % every == 0:
            fuzz.calibrate()
        fuzz.play(items, cuts)

    play()
    fuzz.assert_well()
    assert fuzz.tried >= number * 0.9
