"""The museum arm's pictures, by rays and by MuJoCo's own renderer where the machine has its library."""

import json
import os
import subprocess
import sys

import pytest

from tests.rig import ROOT

TAKE = """
import json, threading
from robots.kit.description import load, views
from simulators.pa10 import scene
from simulators.common.arm.render import make
import mujoco

model = scene.spec().compile()
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
renderer = make(model, 64, 48)
found = {"renderer": type(renderer).__name__}

def take():  # as the camera's server does, in another thread than the one that began
    for view in views(load("pa10")):
        picture = renderer.take(data, view)
        found[view] = [list(picture.shape), str(picture.dtype), float(picture.mean())]

for _ in range(2):
    thread = threading.Thread(target=take)
    thread.start()
    thread.join()
print(json.dumps(found))
"""


@pytest.mark.parametrize("library", ["disable", "osmesa", "egl"])
def test_each_view_shows_the_scene_whatever_library_there_is(library):
    done = subprocess.run(
        [sys.executable, "-c", TAKE], env={**os.environ, "MUJOCO_GL": library}, cwd=ROOT, capture_output=True,
        text=True, check=True,
    )  # fmt: skip
    found = json.loads(done.stdout.splitlines()[-1])
    if library == "disable":
        assert found["renderer"] == "RayRenderer"
    assert found.pop("renderer") in ("RayRenderer", "LibraryRenderer")
    assert set(found) == {"surroundings", "table", "gripper"}
    for shape, kind, brightness in found.values():
        assert (shape, kind) == ([48, 64, 3], "uint8")
        assert 90 < brightness < 200  # lit, with a sky, nothing of the tool cut away
