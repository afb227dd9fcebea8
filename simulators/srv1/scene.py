"""The scene for MuJoCo: the hall's walls, showcases and exhibits, and a hull on four driven wheels.

A wheel is a short capsule, because MuJoCo lays the contact of a capsule on a plane along the capsule's axis. So rubber
can hold less across the wheel than along it, as tyres do that roll and are dragged aside at the same time.
"""

from typing import Any

import mujoco

from robots.kit.description import load
from robots.kit.drivers.srv1.hall import Hall, hall
from simulators.common.rovers.body import FIXED, ROBOT

STEP_S = 0.004
WHEELS = ("front_left", "front_right", "rear_left", "rear_right")
# Friction of a wheel along and across its way. At a turn on the spot a wheel slips along and across; the force of an
# elliptic friction cone leaves (track x ALONG)^2 / ((track x ALONG)^2 + (base x ACROSS)^2) of the turn that the wheels
# say: 0.77 with track 0.20 m and base 0.17 m. With MuJoCo's soft contacts it is 0.74 to 0.77, about a quarter less. A
# straight way needs no force, and loses 0.3 %.
ALONG, ACROSS = 0.80, 0.51
SMOOTH = [0.25, 0.002, 0.0001]  # the hull's plastic on glass and walls
STALL_NM = 0.5  # of a motor: 11 N at the rim; against a wall the wheels spin before they stall
ROTOR = 4e-3  # kg m^2, of a motor behind its gear; with less of it, or more gain, the physics is unstable
GAIN = 0.8  # of a motor's loop, N m s/rad: the rim of a wheel that is dragged aside is some % slow
WHEEL_KG, HALF_TREAD_M = 0.06, 0.008
LOW_M = 0.02  # between floor and hull
WALL_M = 0.1
Geom = mujoco.mjtGeom


def spec(where: Hall | None = None) -> Any:
    """Return the scene, not compiled. Each showcase is a body of its own, which can be moved."""
    where = where or hall()
    made = mujoco.MjSpec()
    made.modelname = "SRV-1"
    made.option.timestep = STEP_S
    made.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    made.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    made.option.impratio = 10
    middle = [where.width / 2, where.depth / 2, 0]
    made.worldbody.add_geom(
        name="floor", type=Geom.mjGEOM_PLANE, size=[where.width, where.depth, 0.1], pos=middle, group=2, contype=0,
        conaffinity=0,
    )  # fmt: skip
    _walls(made, where)
    for case in where.cases:
        body = made.worldbody.add_body(name=case.name, mocap=True, pos=[*case.at, case.high / 2])
        body.add_geom(
            name=case.name, type=Geom.mjGEOM_BOX, size=[*case.half, case.high / 2], friction=SMOOTH, group=FIXED
        )
    for exhibit in where.exhibits:
        made.worldbody.add_geom(
            name=exhibit.name, type=Geom.mjGEOM_CYLINDER, size=[exhibit.radius, exhibit.high / 2, 0],
            pos=[*exhibit.at, exhibit.high / 2], friction=SMOOTH, group=FIXED,
        )  # fmt: skip
    _rover(made)
    return made


def _walls(made: Any, where: Hall) -> None:
    width, depth, half = where.width / 2, where.depth / 2, WALL_M / 2
    for number, (x, y, a, b) in enumerate((
        (width, -half, width + WALL_M, half), (width, where.depth + half, width + WALL_M, half),
        (-half, depth, half, depth), (where.width + half, depth, half, depth),
    )):  # fmt: skip
        made.worldbody.add_geom(
            name=f"wall{number}", type=Geom.mjGEOM_BOX, size=[a, b, where.high / 2], pos=[x, y, where.high / 2],
            friction=SMOOTH, group=FIXED,
        )  # fmt: skip


def _rover(made: Any) -> None:
    body = load("srv1")["body"]
    hull = made.worldbody.add_body(name="hull", pos=[0, 0, 0])
    hull.add_freejoint(name="free")
    top = body["height"]
    hull.add_geom(  # as wide as over its wheels, which touch nothing but the floor
        name="hull", type=Geom.mjGEOM_BOX, size=[body["length"] / 2, body["width"] / 2, (top - LOW_M) / 2],
        pos=[0, 0, (top + LOW_M) / 2], mass=0.0, friction=SMOOTH, group=ROBOT,
    )  # fmt: skip
    hull.add_geom(  # the heavy parts lie low: cells, motors
        type=Geom.mjGEOM_BOX, size=[0.09, 0.06, 0.025], pos=[0, 0, body["wheel_radius"]],
        mass=body["mass"] - 4 * WHEEL_KG, contype=0, conaffinity=0, group=ROBOT,
    )  # fmt: skip
    for name in WHEELS:
        ahead = body["base"] / 2 * (1 if name.startswith("front") else -1)
        aside = body["track"] / 2 * (1 if name.endswith("left") else -1)
        wheel = hull.add_body(name=name, pos=[ahead, aside, body["wheel_radius"]])
        joint = wheel.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 1, 0])
        joint.armature = ROTOR
        wheel.add_geom(
            name=f"{name}_rim", type=Geom.mjGEOM_CAPSULE, fromto=[0, -HALF_TREAD_M, 0, 0, HALF_TREAD_M, 0],
            size=[body["wheel_radius"], 0, 0], mass=WHEEL_KG, group=ROBOT, contype=0, conaffinity=0,
        )  # fmt: skip
        made.add_pair(
            name=name, geomname1="floor", geomname2=f"{name}_rim", condim=3,
            friction=[ACROSS, ALONG, 0.001, 0.0001, 0.0001],
        )  # fmt: skip
        motor = made.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_velocity(kv=GAIN)
        motor.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
        motor.forcerange = [-STALL_NM, STALL_NM]
