"""The table, the plate, the bricks and the rod around the arm of the description, as a MuJoCo model."""

import mujoco
import numpy as np

from robots.kit.description import load
from simulators.common.arm import scene as common
from simulators.puma import clutch, rod
from simulators.puma.cell import DRIVER, PLATE, Bearer, bearers, plate_place, things
from simulators.puma.errors import NONE, Errors

BRICK_KG, STUDS_KG = 0.028, 0.002
OBJECT, RIGID = 1, (0.7, 0.005, 0.0001)  # bit of everything that is no arm; friction
TABLE_M = 1.2  # half its edge
STORE_M = (-2.2, 0.0, -0.75)  # behind the wall, on the floor: where things are that are not in the cell
MUG, MUG_M = "mug", (0.042, 0.048)  # radius, half height
MUG_PLACE = (0.52, 0.10)
FINGER_FRICTION = (1.0, 0.02, 0.001)
PISTON_KG = 0.2  # moves with each finger; lighter ones tremble where they press on each other


def spec(errors: Errors = NONE) -> mujoco.MjSpec:
    """Return the whole scene, not compiled."""
    made = common.scene(DRIVER, "virtual reality arm")
    _fingers(made, errors)
    _surroundings(made)
    for number, bearer in enumerate(bearers()):
        if bearer.name == PLATE:
            body = made.worldbody.add_body(name=PLATE, pos=plate_place())
        else:
            body = _brick_body(made, bearer, errors)
        _solid(body, bearer, number)
    rod.add(made, things()[rod.ROD], clutch.masks(None))
    _mug(made)
    clutch.add_welds(made)
    return made


def _fingers(made: mujoco.MjSpec, errors: Errors) -> None:
    """Let one valve move both fingers, with a friction at which things can slip, where the hidden error has them."""
    (coupled,) = (one for one in made.equalities if one.type == mujoco.mjtEq.mjEQ_JOINT)  # `mimic` of the URDF
    coupled.solref, coupled.solimp = clutch.SOFT
    for name in common.FINGERS:
        made.joint(name).armature = PISTON_KG
    for name in common.PADS:
        pad = made.body(name)
        pad.pos = np.add(pad.pos, errors.tool)
        for geom in pad.geoms:
            if geom.contype:
                geom.friction = FINGER_FRICTION
                geom.solref, geom.solimp = clutch.SOFT


def _surroundings(made: mujoco.MjSpec) -> None:
    box, world = mujoco.mjtGeom.mjGEOM_BOX, made.worldbody
    world.add_geom(name="table", type=box, size=[TABLE_M, TABLE_M, 0.02], pos=[0, 0, -0.02], friction=RIGID,
                   solref=clutch.SOFT[0], solimp=clutch.SOFT[1])  # fmt: skip
    world.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[4, 4, 0.1], pos=[0, 0, STORE_M[2]])


def _brick_body(made: mujoco.MjSpec, bearer: Bearer, errors: Errors) -> mujoco.MjsBody:
    thing = things()[bearer.name]
    x, y, turn = errors.places.get(bearer.name, (0.0, 0.0, 0.0))
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, thing.first[:3, :3].ravel())
    off = np.array([np.cos(turn / 2), 0.0, 0.0, np.sin(turn / 2)])
    mujoco.mju_mulQuat(quaternion, off, quaternion.copy())
    body = made.worldbody.add_body(name=bearer.name, pos=thing.first[:3, 3] + (x, y, 0.0), quat=quaternion)
    body.add_freejoint(name=f"{bearer.name}_free")
    return body


def _solid(body: mujoco.MjsBody, bearer: Bearer, number: int) -> None:
    """Add a bearer's box, and the flat box of its studs."""
    settings, box, moves = load(DRIVER)["clutch"], mujoco.mjtGeom.mjGEOM_BOX, bearer.name != PLATE
    body.add_geom(name=bearer.name, type=box, size=bearer.half, mass=BRICK_KG if moves else 0.0, friction=RIGID,
                  contype=OBJECT, conaffinity=OBJECT | (clutch.masks(number) if moves else 0), condim=4,
                  solref=clutch.SOFT[0], solimp=clutch.SOFT[1])  # fmt: skip
    reach = np.abs(bearer.studs).max(axis=0) + 0.0048
    high = settings["stud_m"] / 2
    body.add_geom(name=f"studs of {bearer.name}", type=box, size=[*reach, high], pos=[0, 0, bearer.half[2] + high],
                  mass=STUDS_KG if moves else 0.0, friction=RIGID, contype=1 << (clutch.STUDS + number), conaffinity=0,
                  condim=4, solref=clutch.SOFT[0], solimp=clutch.SOFT[1])  # fmt: skip


def _mug(made: mujoco.MjSpec) -> None:
    """Add a mug that stands in the store until a fault verb brings it."""
    body = made.worldbody.add_body(name=MUG, pos=np.add(STORE_M, (0.0, 0.0, MUG_M[1])))
    body.add_freejoint(name=f"{MUG}_free")
    body.add_geom(name=MUG, type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[*MUG_M, 0], mass=0.3, friction=RIGID, condim=4,
                  contype=OBJECT, conaffinity=OBJECT | clutch.masks(None))  # fmt: skip
