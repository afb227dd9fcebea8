"""The PUMA 560 brings its bricks back in virtual time, judged by the simulator's own positions."""

import numpy as np
import pytest

from robots import services
from robots.kit.arms.objects import objects_of, pose_of
from robots.states import GrantEnd
from tests.world.seeds import hunts
from tests.world.test_puma_tasks import GALLERY
from tests.world.test_tasks import run

pytestmark = [
    pytest.mark.length,
    pytest.mark.parametrize("which", ["puma"], indirect=True),
    pytest.mark.usefixtures("sharp"),
]
NEAR_M = 0.006


def off(portal):
    """Return how far (m) each brick is from its first place."""
    plant, bricks = portal.rig.sim.plant, objects_of("puma").objects.values()
    return {
        one.name: float(np.linalg.norm(plant.pose(one.name)[:3, 3] - pose_of(one.first)[:3, 3]))
        for one in bricks
        if not one.hangs
    }


@hunts(1, 3, 10)
def test_bricks_that_clutch_to_a_figure_are_taken_apart_and_brought_back(portal):
    """The rod, which hangs, comes back by itself."""
    assert run(portal, GALLERY["The figure of five bricks"]).state == "completed"
    assert max(off(portal).values()) > 0.1
    services.end_grant(services.open_grant(portal.robot), GrantEnd.FINISHED, "over", portal.world.now())
    command = portal.final(services.staff_command(portal.row, portal.people["kim"], "tidy"), 400)
    assert (command.state, command.reason) == ("completed", "")
    assert max(off(portal).values()) < NEAR_M, off(portal)
    assert (command.ended_at - command.created_at).total_seconds() < 120
