"""Promises 13, 18, 22 and 47 in virtual time: people, staff and troubles beside each other, judged by a model."""

import pytest

from tests.conftest import at_length
from tests.proof import AT_LENGTH
from tests.world import chaos, crowd
from tests.world.chaos import busy
from tests.world.crowd import Crowd
from tests.world.seeds import hunt, seeds

SECONDS = 100.0 if AT_LENGTH else 60.0
IN_ANY_ORDER = {
    "nothing": (),
    "people's side": crowd.PEOPLES_SIDE,
    "deaths": chaos.DEATHS,
    "clocks": chaos.CLOCKS,
    "everything": crowd.EVERYTHING,
}
TOLD = "{} s of joining, driving, stopping, going, banning, locking out and writing, with {}: nothing that must not be"


@pytest.mark.parametrize("troubles", ["nothing", "everything", *map(at_length, ("people's side", "deaths", "clocks"))])
@seeds(1, 20, 200)
def test_promise_13_people_in_any_order(crowds, proof, troubles, seed):
    hunt(crowds, seed, lambda portal: Crowd(portal).run(SECONDS, IN_ANY_ORDER[troubles]))
    proof.holds(TOLD.format(SECONDS, troubles))


@pytest.mark.parametrize("which", ["pa10", "irat"], indirect=True)
@pytest.mark.parametrize(
    ("troubles", "seconds"),
    [("everything", 20.0), *(pytest.param(one, SECONDS, marks=pytest.mark.length) for one in IN_ANY_ORDER)],
)
@seeds(1, 20, 200)
def test_promise_13_people_of_other_robots(crowds, proof, troubles, seconds, seed):
    """Where nobody drives, people ask for jobs, and staff drive."""
    hunt(crowds, seed, lambda portal: Crowd(portal).run(seconds, IN_ANY_ORDER[troubles]))
    proof.holds(TOLD.format(seconds, troubles))


@seeds(1, 20, 200)
def test_promise_13_people_on_a_busy_machine(crowds, proof, seed):
    hunt(crowds, seed, lambda portal: Crowd(portal, late=True).run(SECONDS, crowd.EVERYTHING), busy)
    proof.holds(TOLD.format(SECONDS, "threads that come up to 1.5 s late"))


@seeds(1, 20, 200)
def test_promise_18_a_faulty_robot_charges_once(crowds, proof, seed):
    hunt(crowds, seed, lambda portal: Crowd(portal).run(SECONDS, chaos.WIRES))
    proof.holds(TOLD.format(SECONDS, "a robot and a cable that fail"))


@seeds(1, 20, 200)
def test_promise_22_people_while_stores_are_away(crowds, proof, seed):
    hunt(crowds, seed, lambda portal: Crowd(portal).run(SECONDS, chaos.STORES))
    proof.holds(TOLD.format(SECONDS, "stores that are away, silent or forget"))


@pytest.mark.parametrize("which", ["errands"], indirect=True)
@pytest.mark.parametrize("troubles", ["everything", at_length("nothing"), at_length("deaths")])
@seeds(1, 20, 200)
def test_promise_47_jobs_beside_turns(errands, crowds, proof, troubles, seed):
    hunt(crowds, seed, lambda portal: Crowd(portal).run(SECONDS, IN_ANY_ORDER[troubles]))
    proof.holds(TOLD.format(SECONDS, f"jobs and {troubles}"))


def test_a_seed_is_a_run_of_a_crowd(crowds):
    histories = []
    for seed in (7, 7, 8):
        portal = crowds(seed)
        Crowd(portal).run(15.0, crowd.EVERYTHING)
        histories.append(portal.world.history)
    assert histories[0] == histories[1] != histories[2]
