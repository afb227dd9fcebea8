"""The scene for MuJoCo: walls, dock and column as boxes, the robot as a hull on two wheels and two casters."""

from math import atan2, cos, hypot, sin
from typing import Any

import mujoco
import numpy as np

from robots.kit.description import load
from simulators.common.rovers.body import FIXED, ROBOT
from simulators.irat.dock import GUIDE_HIGH_M, GUIDES, STOP_HIGH_M, STOP_M
from simulators.irat.drawings import BOARD_M
from simulators.irat.maze import BOARD, COLUMN, DOCK, OPEN_FLOOR, WALL_HIGH_M, WALL_M, Wall, walls

STEP_S = 0.004
WHEELS = ("left", "right")
HULL_LOW_M, HULL_TOP_M = 0.008, 0.075
GRIP, SMOOTH = [0.9, 0.002, 0.0001], [0.15, 0.001, 0.0001]  # wheels on melamine; the hull on foam
STALL_NM = 0.03  # 1.5 N at the rim: a wheel against a wall stalls before it slips
FLOOR = 2  # what touches the floor only: a wheel is a ball here, wider than it is
FREE = 1e-4  # damping of a wheel (N m s/rad)
Geom = mujoco.mjtGeom


def spec(with_maze: bool = True) -> Any:
    """Return the scene, not compiled; without a maze the dock stands alone on the board."""
    made = mujoco.MjSpec()
    made.modelname = "iRat"
    made.option.timestep = STEP_S
    made.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    made.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    made.option.impratio = 5
    made.worldbody.add_geom(name="board", type=Geom.mjGEOM_PLANE, size=[4, 4, 0.1], friction=GRIP, group=2, contype=3,
                            conaffinity=3)  # fmt: skip
    _dock(made)
    if with_maze:
        for wall in (wall for row in walls() for wall in row):
            _wall(made, wall)
        x, y, half = COLUMN
        _box(made, (x, y, 0.1), (half, half, 0.1), 0.0)
    _edges(made, BOARD if with_maze else OPEN_FLOOR)
    _robot(made)
    return made


def _box(made: Any, middle: tuple[float, float, float], half: tuple[float, float, float], heading: float) -> None:
    made.worldbody.add_geom(
        type=Geom.mjGEOM_BOX, size=half, pos=middle, quat=[cos(heading / 2), 0, 0, sin(heading / 2)], friction=SMOOTH,
        group=FIXED,
    )  # fmt: skip


def _wall(made: Any, wall: Wall) -> None:
    (x, y), (a, b) = wall.begin, wall.end
    heading, length = atan2(b - y, a - x), hypot(a - x, b - y)
    middle = (x + a) / 2 + sin(heading) * WALL_M / 2, (y + b) / 2 - cos(heading) * WALL_M / 2, WALL_HIGH_M / 2
    _box(made, middle, (length / 2, WALL_M / 2, WALL_HIGH_M / 2), heading)


def _edges(made: Any, board: tuple[float, float, float, float]) -> None:
    """Stand a rim around the board, so that nothing can leave it."""
    x, y, a, b = board
    middle_x, middle_y, half_x, half_y = (x + a) / 2, (y + b) / 2, (a - x) / 2 + 0.04, (b - y) / 2 + 0.04
    for side in (-1, 1):
        _box(made, (middle_x + side * (half_x - 0.02), middle_y, 0.05), (0.02, half_y, 0.05), 0.0)
        _box(made, (middle_x, middle_y + side * (half_y - 0.02), 0.05), (half_x, 0.02, 0.05), 0.0)


def _dock(made: Any) -> None:
    x, y, heading = DOCK
    turn = np.array([[cos(heading), -sin(heading)], [sin(heading), cos(heading)]])

    def block(begin: tuple[float, float], end: tuple[float, float], high: float) -> None:
        middle = turn @ (np.add(begin, end) / 2) + (x, y)
        half = np.abs(np.subtract(end, begin)) / 2
        _box(made, (middle[0], middle[1], high / 2), (half[0], half[1], high / 2), heading)

    block((-0.02, -BOARD_M / 2), (0.0, BOARD_M / 2), 0.06 + BOARD_M / 2)
    block((0.0, -0.055), (STOP_M, 0.055), STOP_HIGH_M)
    for number, outline in enumerate(GUIDES):
        corners = np.array([[*(turn @ p + (x, y)), z] for p in outline for z in (0.0, GUIDE_HIGH_M)])
        name = f"guide{number}"
        made.add_mesh(name=name, uservert=corners.reshape(-1))
        made.worldbody.add_geom(
            type=Geom.mjGEOM_MESH, meshname=name, friction=SMOOTH, group=FIXED, contype=1, conaffinity=1
        )


def _robot(made: Any) -> None:
    body = load("irat")["body"]
    hull = made.worldbody.add_body(name="hull", pos=[0, 0, 0])
    hull.add_freejoint(name="free")
    radius, high = body["width"] / 2, (HULL_TOP_M - HULL_LOW_M) / 2
    round_m = body["length"] / 2 - radius
    for name, x in (("nose", round_m), ("back", -round_m)):
        hull.add_geom(
            name=name, type=Geom.mjGEOM_CYLINDER, size=[radius, high, 0], pos=[x, 0, HULL_LOW_M + high],
            mass=(body["mass"] - 0.09) / 2, friction=SMOOTH, group=ROBOT,
        )  # fmt: skip
    hull.add_geom(
        name="sides", type=Geom.mjGEOM_BOX, size=[round_m, radius, high], pos=[0, 0, HULL_LOW_M + high], mass=0.0,
        friction=SMOOTH, group=ROBOT,
    )  # fmt: skip
    hull.add_geom(  # the battery, low between the wheels
        type=Geom.mjGEOM_BOX, size=[0.03, 0.02, 0.008], pos=[0, 0, 0.018], mass=0.05, contype=0, conaffinity=0,
        group=ROBOT,
    )  # fmt: skip
    for name, x in (("front", 0.055), ("rear", -0.055)):
        hull.add_geom(
            name=name, type=Geom.mjGEOM_SPHERE, size=[0.006, 0, 0], pos=[x, 0, 0.0065], mass=0.0, condim=1,
            friction=[0, 0, 0], group=ROBOT, contype=FLOOR, conaffinity=FLOOR,
        )  # fmt: skip
    for name, side in zip(WHEELS, (1, -1), strict=True):
        wheel = hull.add_body(name=name, pos=[0, side * body["track"] / 2, body["wheel_radius"]])
        joint = wheel.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 1, 0])
        joint.armature = 2e-5
        joint.damping = [FREE, 0.0, 0.0]
        wheel.add_geom(
            name=f"{name}_rim", type=Geom.mjGEOM_SPHERE, size=[body["wheel_radius"], 0, 0], mass=0.02, friction=GRIP,
            group=ROBOT, condim=3, contype=FLOOR, conaffinity=FLOOR,
        )  # fmt: skip
        motor = made.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_velocity(kv=0.01)
        motor.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
        motor.forcerange = [-STALL_NM, STALL_NM]
