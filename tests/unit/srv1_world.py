"""The hall rover's world in tests: made, driven and brought to rest in its own time."""

from hypothesis import strategies as st

from robots.kit.drivers.srv1.hall import hall
from simulators.common.faults import FaultBoard
from simulators.srv1.plant import TICK_S
from simulators.srv1.world import World

ROOM_M = 0.25  # around the middle of a rover that touches nothing


def world(pose=None, seed=3, charge=1.0, beacon=False):
    noted = []
    made = World(lambda event, **more: noted.append({"event": event, **more}), FaultBoard(), seed, pose, charge, beacon)
    made.noted, made.faults = noted, made._faults
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
    """Return poses at which the rover touches nothing."""
    free = st.tuples(st.floats(0, hall().width), st.floats(0, hall().depth), st.floats(-3.1415, 3.1415))
    return free.filter(lambda pose: hall().distance(*pose[:2]) > ROOM_M)
