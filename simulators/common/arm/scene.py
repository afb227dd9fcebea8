"""Parts of the scenes of simulated arms: the arm of a description, its gripper, its forbidden boxes, and views."""

from collections.abc import Collection, Sequence

import mujoco
import numpy as np

from robots.kit.arms.described import boxes
from robots.kit.description import load, text_of

STEP_S = 0.002  # of the control loop and of the physics: 500 Hz
HIDDEN = 3  # group of shapes that collide but are invisible
JUDGE = 4  # group of the forbidden boxes, which are invisible and collide with nothing
LAMP = (0.8, -0.8, 2.2)  # m
SKY = (196, 204, 212)  # the background beyond the walls
NEAR = 0.002  # shares of the scene's extent: a gripper's camera sits close to the tool
PRESSING_M = -0.02  # where a closing finger wants to be: beyond the other's pad
FINGERS, PADS = ("left_finger", "right_finger"), ("left_pad", "right_pad")
Place = tuple[float, float, float]


def arm(driver: str) -> mujoco.MjSpec:
    """Return the arm of the description alone, with the inertia and friction of its drives."""
    made = mujoco.MjSpec.from_string(text_of(driver, "model.urdf"))
    for joint in made.joints:
        turns = joint.type == mujoco.mjtJoint.mjJNT_HINGE
        joint.damping = [0.5 if turns else 2.0, 0.0, 0.0]
        joint.armature = 0.1 if turns else 0.01
    return made


def scene(driver: str, name: str) -> mujoco.MjSpec:
    """Return a scene with the arm, its gripper and its forbidden boxes, a lamp and a sky; not compiled."""
    made = arm(driver)
    made.modelname = name
    made.option.timestep = STEP_S
    made.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    made.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    made.option.impratio = 10
    made.option.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP  # what rests costs nothing until it is touched
    made.visual.headlight.ambient = [0.45, 0.45, 0.45]
    made.visual.headlight.diffuse = [0.3, 0.3, 0.3]
    made.visual.map.znear = NEAR
    _gripper(made, driver)
    sky = np.divide(SKY, 255)
    made.add_texture(name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
                     rgb1=sky, rgb2=sky, width=16, height=96)  # fmt: skip
    made.worldbody.add_light(pos=LAMP, dir=[-0.3, 0.35, -1], castshadow=True, diffuse=[0.7, 0.7, 0.7])
    for box in boxes(load(driver)):
        middle, half = np.add(box.low, box.high) / 2, np.subtract(box.high, box.low) / 2
        made.worldbody.add_geom(name=box.name, type=mujoco.mjtGeom.mjGEOM_BOX, size=half, pos=middle, group=JUDGE,
                                contype=0, conaffinity=0)  # fmt: skip
    return made


def _gripper(made: mujoco.MjSpec, driver: str) -> None:
    """Let the fingers grip objects, and the arm not collide with itself."""
    gripper = load(driver)["gripper"]
    force = float(gripper["force"])
    for name in FINGERS:
        finger = made.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        finger.set_to_position(kp=900.0, kv=30.0)
        finger.ctrlrange = [PRESSING_M, gripper["open"]]
        finger.forcerange = [-force, force]
    for geom in made.geoms:
        if not geom.contype:  # only to be seen
            continue
        geom.group = HIDDEN
        pad = geom.parent.name in PADS
        geom.contype, geom.conaffinity = (1, 1) if pad else (2, 1)
        geom.friction = [1.6, 0.05, 0.001] if pad else [0.8, 0.01, 0.001]
        geom.condim = 4 if pad else 3


def looking(place: Place, at: Place) -> list[float]:
    """Return a camera's x and y axes that look from `place` to `at` (m), the top side up."""
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


class Judge:
    """Measures the least distance of the arm to its forbidden boxes, by MuJoCo's own geometry.

    `limbs`: the links that are judged. `bolted`: pairs of link and box that always touch.
    """

    FAR = 0.5

    def __init__(
        self, model: mujoco.MjModel, driver: str, limbs: Collection[str], bolted: Collection[tuple[str, str]]
    ) -> None:
        self._model = model
        link_of = {
            g: model.body(model.geom_bodyid[g]).name for g in range(model.ngeom) if model.geom_group[g] == HIDDEN
        }
        self._pairs = [
            (geom, model.geom(box.name).id, box.name)
            for geom, link in link_of.items()
            for box in boxes(load(driver))
            if link in limbs and (link, box.name) not in bolted
        ]
        self._points = np.zeros(6)

    def nearest(self, data: mujoco.MjData) -> tuple[float, str]:
        """Return the least distance (m, negative inside) and the box."""
        return min(
            (mujoco.mj_geomDistance(self._model, data, geom, box, self.FAR, self._points), name)
            for geom, box, name in self._pairs
        )
