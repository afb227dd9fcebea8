"""Beds of sand for tests; each is computed once, and every test gets a copy of its own."""

import copy
from functools import cache

from robots.kit.drivers.mercury.beds import FIRST
from simulators.mercury.sand import SandBed


@cache
def _computed(seed, places):
    return SandBed(seed, dict(places))


def fresh(seed, places=FIRST):
    """Return a bed that nobody has touched."""
    return copy.deepcopy(_computed(seed, tuple(places.items())))
