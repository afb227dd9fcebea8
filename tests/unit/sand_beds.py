"""Beds of sand for tests; each is computed once, and every test gets a copy of its own."""

import copy
from functools import cache

from simulators.mercury.sand import SandBed


@cache
def _computed(seed):
    return SandBed(seed)


def fresh(seed):
    """Return a bed that nobody has touched."""
    return copy.deepcopy(_computed(seed))
