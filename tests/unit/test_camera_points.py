"""Where points are in the pictures of calibrated cameras, for whoever reads a click in one (frontend/src/scene/sight.ts)."""

import json
from pathlib import Path

import numpy as np
import pytest

from robots.kit.description import load
from robots.kit.vision.prints import cameras_of

VECTORS = Path(__file__).parents[1] / "vectors" / "camera_points.json"


def test_the_vectors_are_what_the_cameras_of_the_descriptions_see():
    told = json.loads(VECTORS.read_text())
    cameras = {f"{driver} {one.name}": one for driver in ("pa10", "puma") for one in cameras_of(load(driver))}
    assert {one["name"] for one in told["cameras"]} == set(cameras)
    assert len(told["points"]) >= 40
    for point in told["points"]:
        at = cameras[point["camera"]].project(np.array(point["at"], np.float64))
        if point["uv"] is None:
            assert not np.isfinite(at).any()
        else:
            assert at == pytest.approx(point["uv"], abs=1e-6)
