"""The paper's docking test (section 5): 30 random places before the dock, the marker in the picture, nothing else known.

The docking law runs in the simulated robot on an open floor. Beside it, from the same places, equation (1) alone: each angle
as it is measured, and the marker led as far aside as the equation wants, to the edge of the picture.
"""

import math
import random
from dataclasses import dataclass, replace

import cv2
import numpy as np

from benchmarks.stage import median, tell
from robots.kit.drivers.irat import markers
from robots.kit.drivers.irat.brain.mind import dock_markers
from robots.kit.rovers.docking import Docking, DockLimits, Sighting, dock
from simulators.common.faults import FaultBoard
from simulators.irat.cameras import RobotCamera, Stage, jpeg
from simulators.irat.maze import DOCK
from simulators.irat.world import World

STARTS, TRIES, LONGEST_S, STEP_S = 30, 3, 150.0, 0.1
NEAR_M, FAR_M, ASIDE_RAD, TURNED_RAD = 0.35, 1.6, math.radians(60), 0.7
GOAL, SEEN_M = 29, 1.6
ALONE = DockLimits(edge=1.0)


@dataclass(frozen=True)
class End:
    """Whether it mated, after how many failed tries, and when (s)."""

    mated: bool
    tries: int
    seconds: float


class Eye:
    """The robot's camera and the detector of the dock's markers."""

    def __init__(self) -> None:
        self._camera, self._markers = RobotCamera(Stage(False)), dock_markers()

    def look(self, world: World) -> tuple[Sighting | None, Sighting | None]:
        """Return the outer and the small marker, as the brain sees them: in a JPEG, grey."""
        picture = np.frombuffer(jpeg(self._camera.take(world.plant.frame)), np.uint8)
        seen = self._markers.find(np.asarray(cv2.imdecode(picture, cv2.IMREAD_GRAYSCALE), np.uint8))
        outer = next((m.sighting for m in seen if m.number in markers.OUTER_IDS), None)
        return outer, next((m.sighting for m in seen if m.number == markers.SMALL_ID), None)


def start(far: float, aside: float, turned: float) -> World:
    """Return a world with the robot so far (m) from the dock, so far beside its axis (rad), and turned from it (rad)."""
    heading = DOCK[2] + aside
    x, y = DOCK[0] + far * math.cos(heading), DOCK[1] + far * math.sin(heading)
    pose = x, y, math.atan2(DOCK[1] - y, DOCK[0] - x) + turned
    return World(lambda *_, **__: None, FaultBoard(1), 1, pose, 0.5, False)


def run(eye: Eye, world: World, alone: bool) -> End:
    """Dock, and tell how that ended."""
    memory, limits = Docking(), ALONE if alone else DockLimits()
    while world.now < LONGEST_S:
        wanted, memory = dock(*eye.look(world), world.battery.charger_current > 0, memory, STEP_S, limits)
        if alone:
            memory = replace(memory, thetas=())
        if memory.phase in ("charging", "gone") or memory.tries >= TRIES:
            break
        world.drive.velocity(wanted.v, wanted.w, 1, world.now)
        for _ in range(5):
            world.tick()
    return End(memory.phase == "charging", memory.tries, world.now)


def main() -> None:
    """Dock from each place in both ways; find how far the dock is seen straight ahead."""
    dice, eye = random.Random(1), Eye()
    ends: dict[bool, list[End]] = {False: [], True: []}
    unseen = 0
    while len(ends[False]) < STARTS:
        place = dice.uniform(NEAR_M, FAR_M), dice.uniform(-ASIDE_RAD, ASIDE_RAD), dice.uniform(-TURNED_RAD, TURNED_RAD)
        if eye.look(start(*place))[0] is None:
            unseen += 1  # the paper began only where the marker was in the picture
            continue
        for alone, into in ends.items():
            into.append(run(eye, start(*place), alone))
    mated = {alone: [end for end in into if end.mated] for alone, into in ends.items()}
    beside = {
        "first_try": sum(end.tries == 0 for end in mated[False]), "seconds": round(median([e.seconds for e in mated[False]]), 1),
        "equation_alone": len(mated[True]), "equation_alone_first_try": sum(end.tries == 0 for end in mated[True]),
        "places_from_where_it_is_not_seen": unseen, "seen_from_m": seen_from(eye),
    }  # fmt: skip
    holds = len(mated[False]) >= GOAL and seen_from(eye) >= SEEN_M
    tell("docking", len(mated[False]), f"of {STARTS} mate within {TRIES} tries", f">= {GOAL}", holds, beside)


def seen_from(eye: Eye) -> float:
    """Return the farthest distance (m) on the dock's axis up to which the outer marker is seen in at least half the pictures."""
    farthest = 0.0
    for distance in np.arange(1.0, 2.41, 0.1):
        world = start(float(distance), 0.0, 0.0)
        if sum(eye.look(world)[0] is not None for _ in range(10)) < 5:
            break
        farthest = round(float(distance), 1)
    return farthest


if __name__ == "__main__":
    main()
