"""The table, the blocks and the cameras around the museum arm, as a MuJoCo model."""

from math import atan, degrees, radians, tan

import mujoco

from robots.kit.description import load
from simulators.common.arm import scene as common
from simulators.common.arm.scene import STEP_S as STEP_S  # the paper's 500 Hz
from simulators.common.arm.scene import looking

BLOCKS = tuple(
    (block["name"], (block["place"][0], block["place"][1]), (*block["colour"], 1.0)) for block in load("pa10")["object"]
)
BLOCK = load("pa10")["object"][0]["size"][0]  # edge of a block (m)
LIMBS = ("upper_arm", "forearm", "lower_forearm", "wrist", "tool", "left_pad", "right_pad")


def spec() -> mujoco.MjSpec:
    """Return the whole scene, not compiled."""
    made = common.scene("pa10", "museum arm")
    _surroundings(made)
    for name, (x, y), colour in BLOCKS:
        _block(made, name, x, y, colour)
    _cameras(made)
    return made


def _surroundings(made: mujoco.MjSpec) -> None:
    world = made.worldbody
    world.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.55, 0.60, 0.02], pos=[0.35, 0, -0.02],
                   rgba=[0.66, 0.53, 0.39, 1], friction=[0.9, 0.01, 0.001])  # fmt: skip
    world.add_geom(name="leg", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.30, 0.30, 0.355], pos=[0.2, 0, -0.395],
                   rgba=[0.25, 0.27, 0.30, 1])  # fmt: skip
    world.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[4, 4, 0.1], pos=[0, 0, -0.75],
                   rgba=[0.42, 0.45, 0.48, 1])  # fmt: skip
    world.add_geom(name="wall", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.05, 3, 1.6], pos=[-1.6, 0, 0.8],
                   rgba=[0.72, 0.75, 0.78, 1])  # fmt: skip


def _block(made: mujoco.MjSpec, name: str, x: float, y: float, colour: tuple[float, ...]) -> None:
    body = made.worldbody.add_body(name=name, pos=[x, y, BLOCK / 2])
    body.add_freejoint(name=f"{name}_free")
    body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_BOX, size=[BLOCK / 2] * 3, rgba=list(colour), density=450,
                  friction=[1.0, 0.02, 0.001], condim=4)  # fmt: skip


def _cameras(made: mujoco.MjSpec) -> None:
    """The paper's three views: the robot with its surroundings, the table, from the gripper."""
    world = made.worldbody
    description = load("pa10")
    shape = description["camera"]["height"] / description["camera"]["width"]
    for view in description["view"]:
        place, at = tuple(view["place"]), tuple(view["at"])
        fovy = degrees(2 * atan(tan(radians(view["field_deg"]) / 2) * shape))
        world.add_camera(name=view["name"], pos=place, xyaxes=looking(place, at), fovy=fovy)
    tool = made.body("tool")
    tool.add_camera(name="gripper", pos=[0.075, 0, 0.0], xyaxes=looking((0.075, 0, 0.0), (0.0, 0, 0.16)), fovy=70)


class Judge(common.Judge):
    """Measures the least distance of the arm to the forbidden boxes."""

    def __init__(self, model: mujoco.MjModel) -> None:
        super().__init__(model, "pa10", LIMBS, {("upper_arm", "the base")})
