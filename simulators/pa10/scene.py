"""The table, the blocks and the cameras around the arm of the description, as a MuJoCo model."""

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from robots.kit.arms.described import boxes
from robots.kit.description import load, text_of

BLOCKS = tuple(
    (block["name"], (block["place"][0], block["place"][1]), (*block["colour"], 1.0)) for block in load("pa10")["object"]
)
BLOCK = load("pa10")["object"][0]["size"][0]  # edge of a block (m)
STEP_S = 0.002  # the paper's 500 Hz
GRIP_N = 20.0
HIDDEN = 3  # group of shapes that collide but are invisible
JUDGE = 4  # group of the forbidden boxes, which are invisible and collide with nothing
LAMP = (0.8, -0.8, 2.2)
SKY = (196, 204, 212)  # the background beyond the wall
NEAR = 0.002  # shares of the scene's extent: the gripper's camera sits close to the tool


def arm() -> mujoco.MjSpec:
    """Return the arm of the description alone, with the inertia and friction of its drives."""
    made = mujoco.MjSpec.from_string(text_of("pa10", "model.urdf"))
    for joint in made.joints:
        turns = joint.type == mujoco.mjtJoint.mjJNT_HINGE
        joint.damping = [0.5 if turns else 2.0, 0.0, 0.0]
        joint.armature = 0.1 if turns else 0.01
    return made


def spec() -> mujoco.MjSpec:
    """Return the whole scene, not compiled."""
    made = arm()
    made.modelname = "museum arm"
    made.option.timestep = STEP_S
    made.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    made.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    made.option.impratio = 10
    made.option.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP  # blocks at rest cost nothing until they are touched
    made.visual.headlight.ambient = [0.45, 0.45, 0.45]
    made.visual.headlight.diffuse = [0.3, 0.3, 0.3]
    made.visual.map.znear = NEAR
    _arm(made)
    _surroundings(made)
    for name, (x, y), colour in BLOCKS:
        _block(made, name, x, y, colour)
    _cameras(made)
    for box in forbidden():
        middle, half = np.add(box.low, box.high) / 2, np.subtract(box.high, box.low) / 2
        made.worldbody.add_geom(name=box.name, type=mujoco.mjtGeom.mjGEOM_BOX, size=half, pos=middle, group=JUDGE,
                                contype=0, conaffinity=0)  # fmt: skip
    return made


def _arm(made: mujoco.MjSpec) -> None:
    """Make the fingers hold, and let links not collide with their neighbours."""
    description = load("pa10")
    for name in ("left_finger", "right_finger"):
        finger = made.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        finger.set_to_position(kp=900.0, kv=30.0)
        finger.ctrlrange = [-0.02, description["gripper"]["open"]]
        finger.forcerange = [-GRIP_N, GRIP_N]
    for geom in made.geoms:
        if not geom.contype:  # only to be seen
            continue
        geom.group = HIDDEN
        pad = geom.parent.name in ("left_pad", "right_pad")
        geom.contype, geom.conaffinity = (1, 1) if pad else (2, 1)  # the arm collides with objects, not with itself
        geom.friction = [1.6, 0.05, 0.001] if pad else [0.8, 0.01, 0.001]
        geom.condim = 4 if pad else 3


def _surroundings(made: mujoco.MjSpec) -> None:
    world, sky = made.worldbody, np.divide(SKY, 255)
    made.add_texture(name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
                     rgb1=sky, rgb2=sky, width=16, height=96)  # fmt: skip
    world.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.55, 0.60, 0.02], pos=[0.35, 0, -0.02],
                   rgba=[0.66, 0.53, 0.39, 1], friction=[0.9, 0.01, 0.001])  # fmt: skip
    world.add_geom(name="leg", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.30, 0.30, 0.355], pos=[0.2, 0, -0.395],
                   rgba=[0.25, 0.27, 0.30, 1])  # fmt: skip
    world.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[4, 4, 0.1], pos=[0, 0, -0.75],
                   rgba=[0.42, 0.45, 0.48, 1])  # fmt: skip
    world.add_geom(name="wall", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.05, 3, 1.6], pos=[-1.6, 0, 0.8],
                   rgba=[0.72, 0.75, 0.78, 1])  # fmt: skip
    world.add_light(pos=LAMP, dir=[-0.3, 0.35, -1], castshadow=True, diffuse=[0.7, 0.7, 0.7])


def _block(made: mujoco.MjSpec, name: str, x: float, y: float, colour: tuple[float, ...]) -> None:
    body = made.worldbody.add_body(name=name, pos=[x, y, BLOCK / 2])
    body.add_freejoint(name=f"{name}_free")
    body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_BOX, size=[BLOCK / 2] * 3, rgba=list(colour), density=450,
                  friction=[1.0, 0.02, 0.001], condim=4)  # fmt: skip


def _cameras(made: mujoco.MjSpec) -> None:
    """The paper's three views: the robot with its surroundings, the table, from the gripper."""
    world = made.worldbody
    for name, place, at, fovy in (
        ("surroundings", (1.75, -1.35, 1.15), (0.15, 0.0, 0.45), 45),
        ("table", (0.95, 0.0, 0.75), (0.52, 0.0, 0.0), 50),
    ):
        world.add_camera(name=name, pos=place, xyaxes=_looking(place, at), fovy=fovy)
    tool = made.body("tool")
    tool.add_camera(name="gripper", pos=[0.075, 0, 0.0], xyaxes=_looking((0.075, 0, 0.0), (0.0, 0, 0.16)), fovy=70)


def _looking(place: tuple[float, float, float], at: tuple[float, float, float]) -> list[float]:
    """Return a camera's x and y axes that look from `place` to `at`, the top side up."""
    back = np.subtract(place, at)
    back = back / np.linalg.norm(back)
    up = np.array([0.0, 0.0, 1.0]) if abs(back[2]) < 0.999 else np.array([0.0, 1.0, 0.0])
    right = np.cross(up, back)
    right = right / np.linalg.norm(right)
    return [*right.tolist(), *np.cross(back, right).tolist()]


def places(model: mujoco.MjModel, names: Sequence[str]) -> tuple[slice, slice]:
    """Return where joints of one number each stand in positions and in velocities; they stand beside each other."""
    at, dof = (int(first[0]) for first in (model.joint(names[0]).qposadr, model.joint(names[0]).dofadr))
    for n, name in enumerate(names):
        assert (model.joint(name).qposadr[0], model.joint(name).dofadr[0]) == (at + n, dof + n), name
    return slice(at, at + len(names)), slice(dof, dof + len(names))


def forbidden() -> tuple[Any, ...]:
    """Return the boxes of the description."""
    return boxes(load("pa10"))


class Judge:
    """Measures the least distance of the arm to the forbidden boxes, by MuJoCo's own geometry."""

    FAR = 0.5

    def __init__(self, model: mujoco.MjModel) -> None:
        limbs = {"upper_arm", "forearm", "lower_forearm", "wrist", "tool", "left_pad", "right_pad"}
        self._model = model
        solid = [g for g in range(model.ngeom) if model.geom_group[g] == HIDDEN]
        arm = [g for g in solid if model.body(model.geom_bodyid[g]).name in limbs]
        bolted = {(model.body("upper_arm").id, "the base")}
        self._pairs = [
            (g, model.geom(box.name).id, box.name)
            for g in arm
            for box in forbidden()
            if (model.geom_bodyid[g], box.name) not in bolted
        ]
        self._points = np.zeros(6)

    def nearest(self, data: mujoco.MjData) -> tuple[float, str]:
        """Return the least distance (m, negative inside) and the box."""
        return min(
            (mujoco.mj_geomDistance(self._model, data, geom, box, self.FAR, self._points), name)
            for geom, box, name in self._pairs
        )
