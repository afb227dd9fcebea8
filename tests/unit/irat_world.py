"""The iRat's world in tests: made, driven and brought to rest in its own time."""

from simulators.common.faults import FaultBoard
from simulators.irat.plant import TICK_S
from simulators.irat.world import World


def world(pose=None, seed=3, with_maze=True, faults=None):
    noted = []
    made = World(
        lambda event, **more: noted.append({"event": event, **more}), faults or FaultBoard(), seed, pose, 1.0, with_maze
    )
    made.noted = noted
    return made


def drive(one, seconds, linear, angular=0.0):
    for _ in range(round(seconds / TICK_S)):
        one.drive.velocity(linear, angular, 1, one.now)
        one.tick()


def rest(one):
    one.drive.hold()
    for _ in range(100):
        one.tick()
