"""The rod on its threads is caught while it swings, in virtual time, judged by the simulator's own positions."""

import numpy as np
import pytest

from robots.kit.arms.beliefs import How
from robots.kit.arms.described import chain, limbs
from robots.kit.description import load
from simulators.puma import rod
from tests.world.seeds import hunts
from tests.world.test_tasks import beliefs

pytestmark = [pytest.mark.parametrize("which", ["puma"], indirect=True), pytest.mark.usefixtures("sharp")]
TASK = "grasp rod\nexpect holding rod\nmove 550 300 380"
ALONG = np.linspace(0.0, 1.0, 30)


def swings(portal, wind, seconds):
    """Let wind make the rod swing."""
    portal.grant()
    portal.rig.fault("gust", wind)
    portal.world.sleep(seconds)
    portal.rig.clear_faults()


def widest(portal, seconds=2.7):
    """Return how far (m) the rod swings to a side."""
    most = 0.0
    for _ in range(round(seconds / 0.03)):
        portal.world.sleep(0.03)
        most = max(most, abs(float(portal.rig.sim.plant.place("rod")[1]) - 0.30))
    return most


class Watch:
    """The smallest distance (m) of a limb of the arm from a thread."""

    def __init__(self, plant):
        self._plant, self._chain = plant, chain("puma")
        self._limbs = limbs(load("puma"), self._chain)
        self.nearest = np.inf

    def look(self):
        frames = self._chain.frames(self._plant.measured().q)
        for name in rod.THREADS:
            above, below = (np.array(self._plant.data.site(f"{name} {end}").xpos) for end in ("above", "below"))
            thread = below + ALONG[:, None] ** 2 * (above - below)  # the lowest part closest
            for limb in self._limbs:
                ends = np.array([[*limb.begin, 1.0], [*limb.end, 1.0]]) @ frames[limb.joint].T
                axis = ends[0, :3] + ALONG[:, None] * (ends[1] - ends[0])[:3]
                apart = np.linalg.norm(thread[:, None] - axis[None], axis=2).min() - limb.radius
                self.nearest = min(self.nearest, float(apart))


@hunts(2, 6, 20)
def test_the_rod_is_caught_while_it_swings(portal):
    swings(portal, 5.0, 3.0)
    portal.until(lambda: widest(portal) < 0.07, 60, "a swing that can be caught")
    assert widest(portal) > 0.035
    watch = Watch(portal.rig.sim.plant)
    command = portal.issue("task", text=TASK)

    def over():
        watch.look()
        command.refresh_from_db()
        return command.ended_at is not None

    portal.until(over, 120, "the end of the task")
    command.refresh_from_db()
    assert command.reason == ""
    assert command.state == "completed"
    assert portal.rig.sim.plant.place("rod")[2] > 0.35
    assert watch.nearest > 0.004, "no limb comes into the zone of a thread, which is 3 mm to each side"
    assert beliefs(portal)["rod"]["held"]
    assert "won: The rod, caught while it swings" in [one.text for one in command.findings.all()]


@hunts(1, 4, 20)
def test_a_rod_that_swings_too_far_is_not_caught_and_the_task_says_so(portal):
    swings(portal, 5.0, 3.0)
    portal.until(lambda: widest(portal) < 0.2, 60, "a swing that is seen")
    far = widest(portal)
    assert far > 0.1
    moved = portal.rig.count("motion")
    command = portal.final(portal.issue("task", text=TASK), 120)
    assert command.reason.startswith("Line 1 of 3, grasp rod: rod swings by "), command.reason
    assert "wait until it swings less. The arm was held." in command.reason
    told = float(command.reason.split(" swings by ")[1].split()[0]) / 1000
    assert widest(portal) - 0.01 < told < far + 0.01, "it swings less and less"
    assert command.state == "failed"
    assert portal.rig.count("motion") == moved, "nothing has moved"


@hunts(1, 4, 20)
def test_a_rod_that_is_blown_out_of_sight_is_not_grasped_where_it_was(portal):
    swings(portal, 12.0, 12.0)
    assert widest(portal) > 0.3
    moved = portal.rig.count("motion")
    command = portal.final(portal.issue("task", text=TASK), 120)
    assert command.state in ("failed", "rejected")
    assert "wait until it swings less" in command.reason or "evenly" in command.reason, command.reason
    assert portal.rig.count("motion") == moved, "nothing has moved"


@hunts(1, 3, 20)
def test_without_pictures_the_rod_is_grasped_by_belief(portal):
    portal.grant()
    portal.rig.fault("cam_black")
    command = portal.final(portal.issue("task", text=TASK), 120)
    assert (command.state, command.reason) == ("completed", "")
    assert portal.rig.sim.plant.place("rod")[2] > 0.35


@hunts(1, 4, 20)
def test_where_the_rod_hangs_is_measured(portal):
    portal.ready()
    assert beliefs(portal)["rod"]["how"] == How.MEASURED
    assert beliefs(portal)["rod"]["place"] == pytest.approx(portal.rig.sim.plant.place("rod"), abs=0.0005)
