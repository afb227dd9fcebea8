"""Promises 13, 14, 17, 18, 22 and 47 in virtual time: people, staff and troubles beside each other, judged by a model."""

import pytest

from tests.proof import AT_LENGTH
from tests.world import chaos, crowd
from tests.world.chaos import busy
from tests.world.crowd import Crowd
from tests.world.seeds import hunt, seeds

SECONDS = 400.0 if AT_LENGTH else 100.0
TROUBLES = {
    "nothing": (),
    "people's side": crowd.PEOPLES_SIDE,
    "stores": chaos.STORES,
    "wires": chaos.WIRES,
    "deaths": chaos.DEATHS,
    "clocks": chaos.CLOCKS,
    "everything": crowd.EVERYTHING,
}


@pytest.mark.parametrize("troubles", TROUBLES)
@seeds(2, 20, 200)
def test_people_in_any_order(crowds, troubles, seed):
    hunt(crowds, seed, lambda portal: Crowd(portal).run(SECONDS, TROUBLES[troubles]))


@seeds(2, 20, 200)
def test_people_on_a_busy_machine(crowds, seed):
    hunt(crowds, seed, lambda portal: Crowd(portal, late=True).run(SECONDS, crowd.EVERYTHING), busy)


@pytest.mark.parametrize("which", ["errands"], indirect=True)
@pytest.mark.parametrize("troubles", ["nothing", "everything"])
@seeds(2, 20, 200)
def test_jobs_beside_turns(errands, crowds, troubles, seed):
    hunt(crowds, seed, lambda portal: Crowd(portal, jobs=True).run(SECONDS, TROUBLES[troubles]))
