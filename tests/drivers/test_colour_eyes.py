"""Blocks are recognised by their colours alone, judged by drawn pictures of the museum arm's table."""

import cv2
import mujoco
import numpy as np
import pytest

from robots.kit.arms.arrangement import Arrangement
from robots.kit.arms.described import posture
from robots.kit.arms.objects import objects_of
from robots.kit.contract.errors import CameraFault
from robots.kit.contract.objects import Placed
from robots.kit.contract.session import Session
from robots.kit.description import load
from robots.kit.drivers.arm_eyes import eyes_of
from simulators.common.arm.render import RayRenderer
from simulators.pa10.plant import Plant

READY = np.array(posture(load("pa10"), "ready"))
TABLE = objects_of("pa10")
FIRST = Arrangement(TABLE, TABLE.first())
NEAR_M = 0.010


class Clock:
    def monotonic(self):
        return 1.0


class Viewer(Session):
    """A session whose owner takes pictures of the simulated table, as JPEGs."""

    def __init__(self):
        super().__init__("", {})
        self.clock, self.plant, self.gone = Clock(), Plant(READY), False
        self._renderer, self._dice = RayRenderer(self.plant.model, 320, 240), np.random.default_rng(1)
        self.on_look = self._take

    def _take(self, view, colour=False):
        if self.gone:
            raise CameraFault("The camera does not answer.")
        mujoco.mj_kinematics(self.plant.model, self.plant.data)
        mujoco.mj_camlight(self.plant.model, self.plant.data)
        picture = self._renderer.take(self.plant.data, view).astype(int)
        noisy = np.clip(picture + self._dice.integers(-2, 3, picture.shape), 0, 255).astype(np.uint8)
        coded = cv2.imencode(".jpg", noisy[:, :, ::-1], [cv2.IMWRITE_JPEG_QUALITY, 85])[1]
        return cv2.imdecode(coded, cv2.IMREAD_COLOR)

    def put(self, name, x, y, z=0.02, yaw=0.0):
        at = int(self.plant.model.joint(f"{name}_free").qposadr[0])
        self.plant.data.qpos[at : at + 7] = [x, y, z, np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)]

    connect = state = execute = hold = close = None


Viewer.__abstractmethods__ = frozenset()


@pytest.fixture(scope="module")
def table():
    viewer = Viewer()
    return viewer, eyes_of(viewer, "pa10")


def apart(pose, x, y, z=0.02):
    return float(np.linalg.norm(pose[:3, 3] - (x, y, z)))


def scattered(dice):
    """Return a place (x, y, yaw) for each block, none near another."""
    found = {}
    for name in TABLE.objects:
        while name not in found:
            x, y = dice.uniform(0.36, 0.68), dice.uniform(-0.36, 0.36)
            if all(np.hypot(x - a, y - b) > 0.1 for a, b, _ in found.values()):
                found[name] = x, y, dice.uniform(0.0, np.pi / 2)
    return found


def test_blocks_anywhere_are_measured_to_a_centimetre_whatever_was_believed(table):
    viewer, eyes = table
    dice, measured = np.random.default_rng(5), 0
    for _ in range(4):
        places = scattered(dice)
        for name, (x, y, yaw) in places.items():
            viewer.put(name, x, y, yaw=yaw)
        sight = eyes.look(FIRST, READY)
        assert sight.blind == ""
        for name, pose in sight.poses.items():
            assert apart(pose, *places[name][:2]) < NEAR_M, name
        measured += len(sight.poses)
    assert measured >= 14, "of sixteen"


def test_a_block_on_another_is_seen_there_and_what_it_hides_is_not_gone(table):
    viewer, eyes = table
    for name, one in TABLE.first().items():
        viewer.put(name, *one.place[:2])
    x, y, _ = TABLE.first()["yellow"].place
    viewer.put("red", x, y, 0.06)
    sight = eyes.look(FIRST, READY)
    assert apart(sight.poses["red"], x, y, 0.06) < NEAR_M
    assert "yellow" in sight.noticed
    assert sight.missing == frozenset()


def test_a_block_that_was_taken_away_is_missing_and_no_camera_means_blind(table):
    viewer, eyes = table
    for name, one in TABLE.first().items():
        viewer.put(name, *one.place[:2])
    viewer.put("blue", 3.0, 3.0)
    assert eyes.look(FIRST, READY).missing == {"blue"}
    believed = Arrangement(TABLE, {**FIRST.places, "blue": Placed((0.45, 0.25, 0.02))})
    assert eyes.look(believed, READY).missing == {"blue"}
    viewer.gone = True
    sight = eyes.look(FIRST, READY)
    viewer.gone = False
    assert "gives no picture" in sight.blind
    assert (sight.poses, sight.missing) == ({}, frozenset())
