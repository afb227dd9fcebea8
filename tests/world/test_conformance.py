"""The conformance suite in virtual time, where no stall of the machine can reach it: the Mercury arm, the PUMA 560, the hall rover."""

import pytest

from robots.kit.conformance.report import Verdict
from robots.kit.conformance.suite import conform
from robots.kit.conformance.trial import Limits
from robots.kit.contract.find import spec_of
from robots.kit.description import load
from tests.conftest import at_length
from tests.world.mercury import MercuryRig
from tests.world.puma import PumaRig
from tests.world.srv1 import RoverRig
from tests.world.world import World

pytestmark = pytest.mark.django_db(transaction=True)


class Board:
    """The rig's faults as a fault board."""

    def __init__(self, rig, boot):
        self.rig, self.boots = rig, boot

    def set(self, verb, value=1.0, count=None):
        self.rig.sim.faults.set(verb, value, count)
        return True

    def clear(self):
        self.rig.clear_faults()

    def motions(self):
        return self.rig.count("motion")

    def moving(self):
        return self.rig.moving


def until_begun(world):
    """Wait for all threads of the simulator, which are none of the driver's."""
    begun = world.monotonic()
    world.until(lambda: world.monotonic() > begun + 1.0, 10, "all threads of the simulator")


def left_out(made, folder, seed, boot, watch_s, **settings):
    """Let the driver of a rig be tried; return the checks that do not apply. `boot` reads the number of its start."""
    world = World(seed)
    rig = made(world, folder)
    name, description = rig.driver, load(rig.driver)
    try:
        until_begun(world)
        report = conform(
            lambda: rig.session(name, "", settings), spec_of(name), world, description=description,
            examples=description.get("conformance", {}), faults=lambda: Board(rig, lambda: boot(rig.sim)),
            limits=Limits(watch_s=watch_s),
        )  # fmt: skip
    finally:
        rig.close()
        world.close()
    assert not report.failures, report.text()
    return {r.check for r in report.results if r.verdict == Verdict.NOT_APPLICABLE}


def of_controller(sim):
    return sim.controller.boot


@pytest.mark.parametrize("seed", [1, at_length(2)])
def test_the_mercury_arm_conforms_in_virtual_time(tmp_path, seed):
    left = left_out(MercuryRig, tmp_path, seed, of_controller, 4.0)
    assert left == {"replaced", "policies", "pictures", "streams", "steered", "time left"}


@pytest.mark.parametrize("seed", [1, at_length(2)])
def test_the_puma_conforms_in_virtual_time(tmp_path, seed):
    left = left_out(PumaRig, tmp_path, seed, of_controller, 4.0)
    assert left == {"replaced", "policies", "pictures", "time left"}


@pytest.mark.parametrize("seed", [1, at_length(2)])
def test_the_hall_rover_conforms_in_virtual_time(tmp_path, seed):
    # a look around, before which it does not know its place, takes so long
    left = left_out(RoverRig, tmp_path, seed, lambda sim: sim.firmware.boot, 45.0, epoch=1)
    assert left <= {"replaced", "streams"}  # whether it is out of reach for a while is chance
