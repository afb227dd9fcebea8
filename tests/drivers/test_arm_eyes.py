"""The eyes of an arm: which pictures count, what hides an object, and when one is missing; judged by drawn pictures."""

import cv2
import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robots.kit.arms.arrangement import Arrangement
from robots.kit.arms.described import chain, limbs, planner, posture
from robots.kit.arms.goals import goals_of
from robots.kit.arms.hiding import Hiding
from robots.kit.arms.objects import objects_of, placed_of, pose_of, yaw_of
from robots.kit.arms.pose import matrix
from robots.kit.contract.errors import CameraFault
from robots.kit.contract.session import Session
from robots.kit.description import load
from robots.kit.drivers import arm_eyes
from robots.kit.drivers.arm_eyes import PAUSE_S, eyes_of
from simulators.puma.plant import Plant
from simulators.puma.render import RasterRenderer
from tests.puma_operator import Operator

READY = posture(load("puma"), "ready")
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
TABLE = objects_of("puma")


class Clock:
    now = 100.0

    def monotonic(self):
        return self.now


class Viewer(Session):
    """A session whose owner takes pictures of a simulated cell. `bad`: what a camera shows instead."""

    def __init__(self, q=READY):
        super().__init__("", {})
        self.clock, self.plant, self.asked, self.bad = Clock(), Plant(q), [], {}
        self._renderer, self._dice = RasterRenderer(self.plant.model, 640, 480), np.random.default_rng(1)
        self.on_look = self._take

    def _take(self, view, colour=False):
        self.asked.append(view)
        if view in self.bad:
            if self.bad[view] is None:
                raise CameraFault("The camera does not answer.")
            return self.bad[view]
        mujoco.mj_kinematics(self.plant.model, self.plant.data)
        grey = cv2.cvtColor(self._renderer.take(self.plant.data, view), cv2.COLOR_RGB2GRAY).astype(int)
        return np.clip(grey + self._dice.integers(-2, 3, grey.shape), 0, 255).astype(np.uint8)

    connect = state = execute = hold = close = None


Viewer.__abstractmethods__ = frozenset()


@pytest.fixture
def viewer():
    return Viewer()


def believed():
    return Arrangement(TABLE, TABLE.first())


def test_an_arm_without_calibrated_cameras_has_no_eyes(viewer, monkeypatch):
    monkeypatch.setattr(arm_eyes, "load", lambda driver: {**load(driver), "view": []})
    assert eyes_of(viewer, "puma") is None
    assert eyes_of(viewer, "pa10") is None


def test_an_arm_with_calibrated_cameras_but_without_markers_has_no_eyes(viewer, monkeypatch):
    bare = {**load("puma"), "object": [{**one, "markers": []} for one in load("puma")["object"]]}
    monkeypatch.setattr(arm_eyes, "load", lambda driver: bare)
    assert eyes_of(viewer, "puma") is None


def test_what_is_there_is_measured_and_nothing_is_missing(viewer):
    sight = eyes_of(viewer, "puma").look(believed(), READY)
    assert sight.noticed == {*"abcde", "rod"}
    assert (sight.missing, sight.blind) == (set(), "")
    assert viewer.asked == ["front", "front", "side", "side"]


def test_a_brick_that_was_taken_away_is_missing_and_one_that_was_moved_is_not(viewer):
    viewer.plant.put("c", np.array([-2.2, 0.9, -0.74]), UPRIGHT)
    viewer.plant.put("a", np.array([0.45, -0.10, 0.0096]), UPRIGHT)
    sight = eyes_of(viewer, "puma").look(believed(), READY)
    assert sight.missing == {"c"}
    assert sight.poses["a"][:2, 3] == pytest.approx([0.45, -0.10], abs=0.0005)


def test_the_arm_hides_what_is_behind_its_limbs_and_its_hand():
    arm = chain("puma")
    hiding = Hiding(arm, limbs(load("puma"), arm), TABLE)
    above, tool = np.array([0.0, 0.0, 1.0]), arm.forward(READY)[:3, 3]
    forearm = (arm.frames(READY)[2] @ [0.0203, 0.0, 0.16, 1.0])[:3]
    for beneath in (forearm, tool):
        point = np.array([[*beneath[:2], 0.01]])
        assert hiding.hides(READY, [], beneath + 1.5 * above, point)
        assert not hiding.hides(READY, [], beneath + 1.5 * above, point + np.array([0.25, 0.25, 0.0]))
        assert not hiding.hides(READY, [], point[0] + np.array([0.6, 0.6, 0.05]), point), "from beside it"


def test_what_the_arm_hides_is_not_missing(viewer):
    """The brick is away; where it would be is inside the forearm."""
    viewer.plant.put("c", np.array([-2.2, 0.9, -0.74]), UPRIGHT)
    first, arm = believed(), chain("puma")
    pose = pose_of(first.places["c"])
    pose[:3, 3] = (arm.frames(READY)[2] @ [0.0203, 0.0, 0.16, 1.0])[:3]
    hidden = Arrangement(TABLE, {**first.places, "c": placed_of(pose)})
    assert "c" not in eyes_of(viewer, "puma").look(hidden, READY).missing


def test_what_another_object_covers_is_not_missing(viewer):
    """Bricks stand around and on the place where c would be."""
    viewer.plant.put("c", np.array([-2.2, 0.9, -0.74]), UPRIGHT)
    first, around = believed(), {}
    for name, (x, y, z) in {
        "a": (0, 0, 0.0192), "b": (0, -0.0318, 0), "d": (0, 0.0318, 0), "e": (0.0636, 0, 0)
    }.items():  # fmt: skip
        pose = pose_of(first.places["c"])
        pose[:3, 3] += x, y, z
        around[name] = placed_of(pose)
        viewer.plant.put(name, pose[:3, 3], UPRIGHT)
    sight = eyes_of(viewer, "puma").look(Arrangement(TABLE, {**first.places, **around}), READY)
    assert "c" not in sight.missing


def test_what_the_object_in_the_gripper_covers_is_not_missing():
    """The fourth brick of the figure is pressed across the place where the third one would be."""
    parts, places = goals_of("puma")[0].parts, dict(TABLE.first())
    tool = parts["d"] @ TABLE.objects["d"].grasps[0].tool
    q = planner("puma").reach(tool, READY)
    viewer = Viewer(q)
    operator = Operator(viewer.plant)
    for name in "abcd":
        operator.put(name, *parts[name][:3, 3], yaw_of(parts[name]))
        places[name] = placed_of(parts[name])
    places["d"] = placed_of(np.linalg.inv(tool) @ parts["d"], held=True)
    operator.put("c", -2.2, 0.9, -0.74)
    sight = eyes_of(viewer, "puma").look(Arrangement(TABLE, places), q)
    assert "c" not in sight.noticed, "there is nothing to judge"
    assert sight.missing == set()


def test_what_leans_in_the_gripper_is_not_measured_as_level_by_one_camera():
    """By 3 degrees: a camera alone does not tell that from a level brick a little higher."""
    tool = matrix((0.579, -0.285, 0.11, np.pi, np.radians(-3.0), np.pi))
    grip = np.linalg.inv(TABLE.objects["d"].grasps[0].tool)
    q = planner("puma").reach(tool, READY)
    viewer = Viewer(q)
    viewer.bad["side"] = None
    there = viewer.plant.model.joint("d_free").qposadr[0]
    turn = Rotation.from_matrix((tool @ grip)[:3, :3]).as_quat(scalar_first=True)
    viewer.plant.data.qpos[there : there + 7] = [*(tool @ grip)[:3, 3], *turn]
    places = {**TABLE.first(), "d": placed_of(grip, held=True)}
    assert "d" not in eyes_of(viewer, "puma").look(Arrangement(TABLE, places), q).poses


def test_a_camera_that_gave_no_picture_is_asked_again_later_or_by_who_insists(viewer):
    eyes = eyes_of(viewer, "puma")
    viewer.bad["side"] = None
    sight = eyes.look(believed(), READY)
    assert sight.blind == "", "the other camera shows something"
    assert viewer.asked.count("side") == 1
    eyes.look(believed(), READY)
    assert viewer.asked.count("side") == 1
    eyes.look(believed(), READY, insists=True)
    assert viewer.asked.count("side") == 2
    viewer.clock.now += PAUSE_S
    eyes.look(believed(), READY)
    assert viewer.asked.count("side") == 3


SHAPE = (480, 640)


@pytest.mark.parametrize(
    ("picture", "says"),
    [
        (None, "the camera front gives no picture, the camera side gives no picture"),
        (np.zeros(SHAPE, np.uint8), "the picture of the camera front is black, the picture of the camera side is black"),
        (np.full(SHAPE, 90, np.uint8),
         "the picture of the camera front stands still, the picture of the camera side stands still"),
        (np.full((240, 320), 90, np.uint8),
         "the pictures of the camera front are not as large as described, "
         "the pictures of the camera side are not as large as described"),
    ],
)  # fmt: skip
def test_bad_pictures_show_nothing_and_say_why(viewer, picture, says):
    viewer.bad = {"front": picture, "side": picture}
    sight = eyes_of(viewer, "puma").look(believed(), READY)
    assert (sight.poses, sight.noticed, sight.missing) == ({}, frozenset(), frozenset())
    assert sight.blind == says


def test_noise_shows_nothing(viewer):
    dice = np.random.default_rng(2)
    viewer.on_look = lambda view: dice.integers(0, 256, SHAPE).astype(np.uint8)
    sight = eyes_of(viewer, "puma").look(believed(), READY)
    assert (sight.poses, sight.missing, sight.blind) == ({}, frozenset(), "no marker can be read in the pictures")


def test_a_session_without_an_owner_has_no_camera(viewer):
    viewer.on_look = None
    with pytest.raises(CameraFault, match="no camera"):
        viewer.look("front")
    assert "gives no picture" in eyes_of(viewer, "puma").look(believed(), READY).blind
