"""Moving pictures of the simulators' cameras: what the scene looks like, and what the robot's worker gets of it.

The first has no noise of a sensor in it (with NOISE=1 it has) and was never compressed; the second has both, the
robot's own JPEG included.
"""

import io
import os
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import count
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from robots.kit.description import coding, load, views

Picture = np.ndarray
Pair = tuple[Picture, Picture]  # the scene, and what the worker gets; blue, green, red, or grey
NOISE = bool(os.environ.get("NOISE"))
CAMERA_QUALITY = 94  # of simulators.common.camera_server
MERCURY_S, ARM_RAD_S = 0.002, 0.5
TURN_EVERY_S = 6.0  # an operator who looks before the next move


@dataclass(frozen=True)
class Scene:
    """A camera's pictures: how many a second, how many joints its packets tell, and a way to take them all."""

    name: str
    fps: float
    joints: int
    quantizer: int | None
    coding: str
    take: Callable[[int], list[Pair]]


def _seen(picture: Picture) -> Picture:
    """Return a picture (red, green, blue, or grey) as the worker gets it from a network camera."""
    out = io.BytesIO()
    Image.fromarray(picture).save(out, "JPEG", quality=CAMERA_QUALITY)
    how = cv2.IMREAD_COLOR if picture.ndim == 3 else cv2.IMREAD_GRAYSCALE
    return np.asarray(cv2.imdecode(np.frombuffer(out.getvalue(), np.uint8), how))


def _mercury(every_s: float) -> Callable[[int], list[Pair]]:
    """Return how pictures are taken while the arm moves over its sand; a move each `every_s`, or without a pause."""

    def take(many: int) -> list[Pair]:
        from simulators.mercury import camera
        from simulators.mercury.sand import SandBed

        bed, rng, found = SandBed(4), np.random.default_rng(1), []
        for x, y in ((5, 420), (-150, 470), (110, 350)):
            for _ in range(7):
                for dx, dy in ((-8, 7), (8, 7), (8, -7), (-8, -7)):
                    bed.blow(x + dx, y + dy, 0.15)
        exposure, noise = load("mercury")["camera"]["delivery_exposure_s"], camera.NOISE
        for poses in _moves(rng, every_s, int(0.25 / MERCURY_S), int(exposure / MERCURY_S) + 1):
            seen = camera.expose(bed, poses, exposure, rng)
            camera.NOISE = 0.0
            found.append((seen if NOISE else camera.expose(bed, poses, exposure, rng), _seen(seen)))
            camera.NOISE = noise
            if len(found) == many:
                return found
        return found

    return take


def _moves(rng: np.random.Generator, every_s: float, steps: int, last: int) -> Iterator[list]:
    """Yield where the tool was in the `last` of each `steps` steps."""
    from simulators.mercury.arm import Line, Pose

    home, motion = load("mercury")["home"], load("mercury")["motion"]
    at, line, due, poses = Pose(home["x"], home["y"], 0.075, 0.0), None, 0.0, []
    for step in count(1):
        if line is None and step * MERCURY_S >= due:
            due = step * MERCURY_S + every_s
            target = Pose(rng.uniform(-0.24, 0.24), rng.uniform(0.29, 0.55), float(rng.choice([0.0, 0.075])), 0.0)
            line = Line(at, target, motion["speed"])
        if line is not None:
            _, ended = line.advance(MERCURY_S)
            at, line = line.at(), None if ended else line
        poses.append(at.as_tuple())
        if step % steps == 0:
            yield poses[-last:]
            poses.clear()


class _Enough(Exception):
    pass


def _irat(many: int) -> list[Pair]:
    """Take pictures while the robot explores its maze by itself."""
    from simulators.irat.cameras import RobotCamera, jpeg
    from tests.irat_trial import Trial, silent

    found: list[Pair] = []
    every_s = 1 / load("irat")["camera"]["fps"]
    with tempfile.TemporaryDirectory() as folder:
        trial = Trial(Path(folder), width=208)
        stage = trial._camera._stage
        clear, eye, tick = RobotCamera(stage, noise=0), RobotCamera(stage), trial.world.tick
        begun = trial.now + 5.0

        def watched(seconds: float = 0.02) -> None:
            tick(seconds)
            if trial.world.now >= begun + len(found) * every_s:
                hull = trial.world.plant.frame
                raw = eye.take(hull)
                seen = cv2.imdecode(np.frombuffer(jpeg(raw), np.uint8), cv2.IMREAD_COLOR)
                found.append(((raw if NOISE else clear.take(hull))[:, :, ::-1], np.asarray(seen)))
            if len(found) == many:
                raise _Enough

        trial.world.tick = watched
        try:
            while True:
                trial.roaming.explore(lambda: None, silent)
        except _Enough:
            return found


def _arm(view: str) -> Callable[[int], list[Pair]]:
    """Return how pictures are taken while the arm moves all its joints, from one random pose to the next."""

    def take(many: int) -> list[Pair]:
        import mujoco

        from robots.kit.arms.described import chain
        from simulators.common.arm.render import make
        from simulators.pa10 import cameras, scene

        described, rng, found = load("pa10")["camera"], np.random.default_rng(1), []
        model = scene.spec().compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        renderer, arm = make(model, described["width"], described["height"]), chain("pa10")
        at = [model.joint(name).qposadr[0] for name in arm.names]
        low, high = (0.6 * np.array([getattr(j, end) for j in arm.joints]) for end in ("low", "high"))
        q = goal = np.zeros(len(at))
        while len(found) < many:
            if np.abs(goal - q).max() < 1e-6:
                goal = np.clip(rng.normal(0, 0.6, len(at)), low, high)
            q = q + np.clip(goal - q, -ARM_RAD_S / described["fps"], ARM_RAD_S / described["fps"])
            data.qpos[at] = q
            mujoco.mj_kinematics(model, data)
            mujoco.mj_camlight(model, data)
            clear = renderer.take(data, view)
            grain = rng.integers(-cameras.NOISE, cameras.NOISE, clear.shape, dtype=np.int16, endpoint=True)
            raw = np.clip(clear + grain, 0, 255).astype(np.uint8)
            found.append(((raw if NOISE else clear)[:, :, ::-1], _seen(raw)))
        return found

    return take


def scenes() -> list[Scene]:
    """Return all."""
    made = []
    for robot, joints, takes in (
        ("mercury", 4, {"moving": _mercury(0.0), "a move each 6 s": _mercury(TURN_EVERY_S)}),
        ("irat", 0, {"roaming": _irat}),
        ("pa10", 7, {view: _arm(view) for view in views(load("pa10"))}),
    ):
        described = load(robot)
        camera = described["camera"]
        for name, take in takes.items():
            fps, quantizer = float(camera.get("fps", 4)), camera.get("video_quantizer")
            made.append(Scene(f"{robot}, {name}", fps, joints, quantizer, coding(described), take))
    return made
