"""Which seeds a test runs, and what is said of one that fails: how to replay it, and its fewest delays."""

import os
from collections.abc import Callable
from functools import wraps
from inspect import Parameter, Signature

import pytest

from tests.proof import AT_LENGTH, FULL
from tests.world.delays import Delays, These

ONE = os.environ.get("FARHAND_SEED")  # `make world SEED=...`
MOST_TRIES = 0 if "FARHAND_MUTANT" in os.environ else 60  # runs to find the fewest delays


def seeds(gate: int, length: int, full: int = 0):
    """Run a test with so many seeds in `make test`, `make test-all` and `make proofs`."""
    most = max(full, length)
    number = most if FULL else length if AT_LENGTH else gate

    def of(test):
        test.seeds = most
        return pytest.mark.parametrize("seed", [int(ONE)] if ONE else range(1, number + 1), ids="seed{}".format)(test)

    return of


def fewest(
    given: dict[int, float], fails: Callable[[dict[int, float]], bool], most: int = MOST_TRIES
) -> dict[int, float]:
    """Return as few of the delays as still fail (delta debugging: Zeller and Hildebrandt 2002, ddmin)."""
    parts = 2
    while len(given) > 1 and most > 0:
        numbers = sorted(given)
        size = -(-len(numbers) // parts)
        for begin in range(0, len(numbers), size):
            dropped = set(numbers[begin : begin + size])
            fewer = {n: s for n, s in given.items() if n not in dropped}
            most -= 1
            if fails(fewer):
                given, parts = fewer, max(parts - 1, 2)
                break
            if most <= 0:
                break
        else:
            if size == 1:
                break
            parts = min(2 * parts, len(numbers))
    return {} if given and fails({}) else given


def hunt(worlds, seed: int, run: Callable, delays: Callable[[int], Delays] | None = None) -> None:
    """Run `run(portal)` in a world of that seed; a failure says how to see it again, with the fewest delays."""
    late = delays(seed) if delays else These({})

    def fails(given: dict[int, float]) -> bool:
        try:
            run(worlds(seed, These(given)))
        except AssertionError:
            return True
        return False

    try:
        portal = worlds(seed, late)
        run(portal)
        portal.world.check_errors()
    except AssertionError as error:
        error.add_note(f"make world SEED={seed} shows it again.")
        if late.given:
            left = fewest(dict(late.given), fails)
            error.add_note(f"Of {len(late.given)} delays these are enough (wait: s): {left}")
        raise


def hunts(gate: int, length: int, full: int = 0, begin: str = "worlds"):
    """Make `run(portal)` a test that `hunt`s through so many `seeds`; `begin` is the fixture that begins its worlds."""

    def of(run):
        @wraps(run)
        def test(seed, **fixtures):
            hunt(fixtures[begin], seed, run)

        test.__signature__ = Signature([Parameter(name, Parameter.KEYWORD_ONLY) for name in (begin, "seed")])
        return seeds(gate, length, full)(test)

    return of
