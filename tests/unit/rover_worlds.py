"""The worlds of the two simulated rovers in tests: made, driven and brought to rest in their own time."""

from hypothesis import strategies as st

from robots.kit.drivers.srv1.hall import hall
from simulators.common.faults import FaultBoard
from simulators.common.rovers.body import TICK_S
from simulators.irat.world import World as IratWorld
from simulators.srv1.world import World as HallWorld

ROOM_M = 0.25  # around the middle of a rover that touches nothing


def irat(pose=None, seed=3, with_maze=True, faults=None):
    """Return the iRat in its maze; `noted` has what goes into its journal."""
    return noting(IratWorld, faults or FaultBoard(), seed, pose, 1.0, with_maze)


def srv1(pose=None, seed=3, charge=1.0, beacon=False):
    """Return the hall rover in its hall; `noted` has what goes into its journal."""
    return noting(HallWorld, FaultBoard(), seed, pose, charge, beacon)


def noting(kind, faults, *more):
    noted = []
    made = kind(lambda event, **more: noted.append({"event": event, **more}), faults, *more)
    made.noted, made.faults = noted, faults
    return made


def drive(one, seconds, linear, angular=0.0):
    for _ in range(round(seconds / TICK_S)):
        one.drive.velocity(linear, angular, 1, one.now)
        one.tick()


def rest(one):
    one.drive.hold()
    for _ in range(100):
        one.tick()


def poses():
    """Return poses at which the hall rover touches nothing."""
    free = st.tuples(st.floats(0, hall().width), st.floats(0, hall().depth), st.floats(-3.1415, 3.1415))
    return free.filter(lambda pose: hall().distance(*pose[:2]) > ROOM_M)
