"""Promises 1 to 4, 8, 10, 11, 22 and 23 in virtual time: no forbidden motion, whatever happens."""

import pytest

from tests.conftest import EACH_AT_LENGTH
from tests.world import chaos
from tests.world.chaos import Chaos, busy
from tests.world.portal import EACH
from tests.world.seeds import hunt, seeds


@EACH_AT_LENGTH
@pytest.mark.parametrize("troubles", ["STOPS", "STORES", "WIRES", "DEATHS", "CLOCKS"])
@seeds(1, 20, 200)
def test_one_kind_of_trouble(worlds, troubles, seed):
    hunt(worlds, seed, lambda portal: Chaos(portal).run(40, getattr(chaos, troubles)))


@EACH
@seeds(1, 20, 200)
def test_whatever_happens(worlds, seed):
    hunt(worlds, seed, lambda portal: Chaos(portal).run(40, chaos.EVERYTHING))


@EACH
@seeds(1, 20, 200)
def test_whatever_happens_on_a_busy_machine(worlds, seed):
    hunt(worlds, seed, lambda portal: Chaos(portal).run(40, chaos.EVERYTHING), busy)
