"""What the Mercury simulator remembers when it is killed."""

import json

import pytest

from robots.kit.description import load
from simulators.common.nonvolatile import keep, restore
from simulators.mercury.arm import START, Pose
from simulators.mercury.workspace import Workspace

SPOILT = [
    "",
    "{",
    "[]",
    "7",
    '{"pose": [1e308, NaN, 0, 0], "boot": 1e999}',
    '{"pose": 1, "boot": "x"}',
    '{"pose": [0, 0, 0], "boot": 4}',
]


def stored(path):
    """Return pose and boot number of the state that is stored in `path`."""
    return restore(path, Pose.read, START)


def test_what_was_kept_comes_back(tmp_path):
    path = tmp_path / "state.json"
    keep(path, 70_000, {"pose": Pose(0.1, 0.4, 0.0, 0.2).as_tuple()})
    assert stored(path) == (Pose(0.1, 0.4, 0.0, 0.2), 70_000)


def test_the_first_start_has_nothing_to_remember(tmp_path):
    assert stored(tmp_path / "state.json") == (START, 0)


@pytest.mark.parametrize("text", SPOILT)
def test_where_nothing_can_be_read_no_boot_number_comes_back(tmp_path, text):
    path = tmp_path / "state.json"
    path.write_text(text)
    pose, boot = stored(path)
    assert boot > 1_500_000_000, "it goes on from the time of day"
    assert pose == START


@pytest.mark.parametrize("pose", [[9, 9, 9, 9], [1e308, 0, 0, 0], [float("nan"), 0.4, 0, 0], [0, 0, 0, 0]])
def test_a_place_where_the_arm_cannot_stand_is_not_believed(tmp_path, pose):
    path = tmp_path / "state.json"
    path.write_text(json.dumps({"pose": pose, "boot": 4}))
    pose, boot = stored(path)
    assert boot == 4
    assert Workspace(load("mercury")).tidy_pose(pose) is None
