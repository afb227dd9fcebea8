"""The error of the map after 30 minutes of drifting odometry, beside dead reckoning and GTSAM on the same links."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from benchmarks._beside import needed
from benchmarks.stage import tell
from robots.kit.slam.slam import RatSlam
from tests.unit.ratslam_world import OUTER, Drift, World

MINUTES, DT, EACH = 30, 0.05, 2  # a picture every second step
SPEED, RADIUS = 0.15, 0.12
BLOCKS = ((-0.7, -0.175, -0.6, 0.6), (0.175, 0.7, -0.6, 0.6))  # two loops with a corridor between them
X, Y = (OUTER[0] + 0.7) / 2, (OUTER[1] + 0.6) / 2
CORNERS = {"a": (-X, -Y), "b": (0, -Y), "c": (X, -Y), "d": (X, Y), "e": (0, Y), "f": (-X, Y)}
NEXT = {"a": "bf", "b": "ace", "c": "bd", "d": "ce", "e": "dfb", "f": "ea"}
WIDE = 0.02  # how far the robot may be beside the middle of the corridor


def main() -> None:
    """Drive, and judge the map and the others by evo."""
    needed("evo", "gtsam")
    slam, world, drift, dice = RatSlam(), World(blocks=BLOCKS), Drift(share=1.02, bias=0.005), np.random.default_rng(5)
    truth: dict[int, tuple[float, float, float]] = {}
    reckoned: dict[int, tuple[float, float, float]] = {}
    dead, met, steps = (0.0, 0.0, math.pi / 2), 0, 0
    for n, (x, y, facing, v, w) in enumerate(roaming(dice)):
        if n * DT > MINUTES * 60:
            break
        v, w = drift(v, w)
        middle = dead[2] + w * DT / 2
        dead = dead[0] + v * DT * math.cos(middle), dead[1] + v * DT * math.sin(middle), dead[2] + w * DT
        picture = world.picture(x, y, facing) if n % EACH == 0 else None
        step = slam.step(n * DT, picture, v, w, DT)
        met, steps = met + step.met, n
        if step.is_new:
            truth[step.experience], reckoned[step.experience] = (x, y, facing), dead
    held = slam.map
    print(f"{steps} steps: {held.count} experiences, {held.linked} links, {met} of them to places known before")
    ids = held.ids[: held.count].tolist()
    reference = np.array([truth[i] for i in ids])
    found = {
        "ours": held.poses[: held.count],
        "dead reckoning": np.array([reckoned[i] for i in ids]),
        "GTSAM": optimised(held),
    }
    errors = {name: error(poses, reference) for name, poses in found.items()}
    for name, metres in errors.items():
        print(f"{name}: {metres:.4f} m")
    ours, ratio = errors["ours"], errors["ours"] / errors["GTSAM"]
    holds = ours <= 0.05 and ratio <= 1.2 and errors["dead reckoning"] >= 5 * ours
    goal = "<= 0.05, at most 1.2 times GTSAM's, a fifth of dead reckoning's"
    tell("ratslam_map", ours, "m, root mean square", goal, holds, {k: round(v, 4) for k, v in errors.items()})


def roaming(dice: np.random.Generator) -> Iterator[tuple[float, float, float, float, float]]:
    """Yield (x, y, facing, v, w) along the corridors, with a random turn at each junction, for ever."""
    last, at = "a", "b"
    x, y, facing = CORNERS["a"][0] + RADIUS, CORNERS["a"][1], 0.0
    while True:
        then = str(dice.choice([other for other in NEXT[at] if other != last]))
        here, there = np.array(CORNERS[at]), np.array(CORNERS[then])
        along = (here - CORNERS[last]) / np.linalg.norm(here - CORNERS[last])
        turn = math.remainder(math.atan2(*(there - here)[::-1]) - math.atan2(along[1], along[0]), 2 * math.pi)
        straight = float(np.dot(here - (x, y), along)) - (RADIUS if abs(turn) > 0.1 else 0.0)
        wanted = dice.uniform(-WIDE, WIDE)
        corner = RADIUS * abs(turn)
        for length, total in ((max(straight, 0.01), 0.0), (corner, turn)):
            steps = round(length / SPEED / DT)
            for n in range(steps):
                v, w = length / steps / DT, total / steps / DT
                if not total:  # weave to another place beside the middle, and be back on it at the end
                    w = wanted * math.sin(4 * math.pi * n / steps) * 8 * math.pi**2 / length / steps / DT * 0.5
                middle = facing + w * DT / 2
                x, y, facing = x + v * DT * math.cos(middle), y + v * DT * math.sin(middle), facing + w * DT
                yield x, y, facing, v, w
        last, at = at, then


def optimised(held: Any) -> np.ndarray:
    """Return the poses, (n, 3), that GTSAM finds for the same links, all trusted alike, from ours as a start."""
    import gtsam

    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    trust = gtsam.noiseModel.Diagonal.Sigmas(np.array([0.01, 0.01, 0.05]))
    graph.add(gtsam.PriorFactorPose2(0, gtsam.Pose2(*held.poses[0]), trust))
    for n in range(held.linked):
        distance, direction, facing = held.measured[n]
        seen = gtsam.Pose2(distance * math.cos(direction), distance * math.sin(direction), facing)
        graph.add(gtsam.BetweenFactorPose2(int(held.sources[n]), int(held.targets[n]), seen, trust))
    for n in range(held.count):
        values.insert(n, gtsam.Pose2(*held.poses[n]))
    done = gtsam.LevenbergMarquardtOptimizer(graph, values).optimize()
    poses = [done.atPose2(n) for n in range(held.count)]
    return np.array([(pose.x(), pose.y(), pose.theta()) for pose in poses])


def error(found: np.ndarray, truth: np.ndarray) -> float:
    """Return evo's absolute position error (m, root mean square) after the best turn and shift."""
    from evo.core.metrics import APE, PoseRelation, StatisticsType
    from evo.core.trajectory import PoseTrajectory3D

    def made(poses: np.ndarray) -> Any:
        places = np.column_stack([poses[:, :2], np.zeros(len(poses))])
        zero = np.zeros(len(poses))
        facings = np.column_stack([np.cos(poses[:, 2] / 2), zero, zero, np.sin(poses[:, 2] / 2)])
        return PoseTrajectory3D(places, facings, np.arange(len(poses), dtype=float))

    reference, estimate = made(truth), made(found)
    estimate.align(reference)
    judged = APE(PoseRelation.translation_part)
    judged.process_data((reference, estimate))
    return float(judged.get_statistic(StatisticsType.rmse))
