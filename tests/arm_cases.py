"""Motions of an arm that Python and the browser both plan: cases, and what Python makes of them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from robots.kit.arms.chain import Chain
from robots.kit.arms.described import limbs, motion_facts, planner, posture
from robots.kit.arms.path import Limits
from robots.kit.arms.planner import Planner, Refused
from robots.kit.arms.zones import Box, Zones
from robots.kit.description import load

NEAR_RAD = 0.4  # of motions above the table, which boxes seldom end
DRAG_RAD = 0.02  # of one step of a ghost
# Lengths as in the PUMA's description, in the usual form of Denavit and Hartenberg, where each axis is z of its frame.
DENAVIT = ((0.0, np.pi / 2, 0.6718), (0.4318, 0.0, 0.0), (0.0203, -np.pi / 2, 0.15005), (0.0, np.pi / 2, 0.4318), (0.0, -np.pi / 2, 0.0), (0.0, 0.0, 0.15))  # fmt: skip
RANGES = (160, 110, 135, 266, 100, 266)  # degrees to each side


@dataclass
class Arm:
    """An arm to plan for, with what the browser is told of it."""

    planner: Planner
    description: dict[str, Any]
    ready: Any

    @property
    def facts(self):
        return motion_facts(self.description, self.planner.chain)


def shipped(driver):
    """Return an arm that ships with the house."""
    described = load(driver)
    return Arm(planner(driver), described, posture(described, "ready"))


def by_denavit():
    """Return an arm of the same shape as the PUMA whose joints' frames are turned against each other."""
    links, before = ["<link name='l0'/>"], "xyz='0 0 0'"
    for n, ((a, alpha, d), high) in enumerate(zip(DENAVIT, np.radians(RANGES), strict=True), 1):
        limits = f"<limit lower='{-high}' upper='{high}' velocity='{1 + n / 4}' effort='1'/>"
        links.append(
            f"<link name='l{n}'/><joint name='J{n}' type='revolute'><parent link='l{n - 1}'/><child link='l{n}'/>"
            f"<origin {before}/><axis xyz='0 0 1'/>{limits}</joint>"
        )
        before = f"xyz='{a} 0 {d}' rpy='{alpha} 0 0'"
    end = f"<link name='tip'/><joint name='tip' type='fixed'><parent link='l6'/><child link='tip'/><origin {before}/></joint>"
    arm = Chain.from_urdf(f"<robot name='denavit'>{''.join(links)}{end}</robot>", "tip")
    described = {
        "motion": load("puma")["motion"],
        "box": [{"name": "the table", "low": [-1.2, -1.2, -0.8], "high": [1.2, 1.2, 0.0]}],
        "limb": [
            {"name": "upper arm", "joint": "J2", "begin": [0.0, 0.0, 0.0], "end": [0.4318, 0.0, 0.0], "radius": 0.1},
            {"name": "hand", "joint": "J6", "begin": [0.0, 0.0, 0.0], "end": [0.0, 0.0, 0.1], "radius": 0.05},
        ],
    }
    zones = Zones(arm, limbs(described, arm), [Box(b["name"], tuple(b["low"]), tuple(b["high"])) for b in described["box"]])
    motion = described["motion"]
    made = Planner(arm, zones, Limits.of(arm, motion["acceleration_s"]), motion["clearance_m"])
    return Arm(made, described, np.array([0.3, 0.5, -0.4, 0.2, 0.9, 0.1]))


ARMS = {"pa10": lambda: shipped("pa10"), "puma": lambda: shipped("puma"), "denavit": by_denavit}


def singular_joints(arm, dice, kind):
    """Return joints at a singular pose: the wrist straight, the elbow stretched, or the wrist above the shoulder."""
    found = dice.uniform(arm.low, arm.high)
    if kind == "wrist":
        found[4] = 0.0
        return found
    if kind == "elbow":
        found[2] = stretched(arm)
        return found
    for _ in range(60):  # where the wrist's centre lies nearest to the first axis: by halving over the second joint
        found = dice.uniform(arm.low, arm.high)
        second = np.linspace(arm.low[1], arm.high[1], 400)
        tried = np.tile(found, (400, 1))
        tried[:, 1] = second
        gap = np.linalg.norm(arm.frames(tried)[:, 4, :2, 3], axis=1)
        if 0 < np.argmin(gap) < 399:
            break
    found[1] = golden(lambda v: float(np.linalg.norm(centre(arm, found, v)[:2])), second[np.argmin(gap) - 1], second[np.argmin(gap) + 1])
    return found


def centre(arm, q, second):
    q = q.copy()
    q[1] = second
    return arm.frames(q)[4, :3, 3]


def golden(cost, low, high):
    """Return where a function with one minimum is least (golden section)."""
    share = (np.sqrt(5) - 1) / 2
    for _ in range(80):
        a, b = high - share * (high - low), low + share * (high - low)
        low, high = (low, b) if cost(a) < cost(b) else (a, high)
    return (low + high) / 2


def stretched(arm):
    """Return the third angle at which the wrist's centre is farthest from the second axis."""
    def near(third):
        q = np.zeros(6)
        q[2] = third
        frames = arm.frames(q)
        axis = frames[1, :3, :3] @ arm.joints[1].axis
        return -float(np.linalg.norm(np.cross(frames[4, :3, 3] - frames[1, :3, 3], axis)))

    tried = np.linspace(arm.low[2], arm.high[2], 400)
    best = int(np.clip(np.argmin([near(v) for v in tried]), 1, 398))
    return golden(near, tried[best - 1], tried[best + 1])


def drawn(arm, dice, number):
    """Return one case: where the arm is, and a pose of the tool or joints to go to."""
    chain_, kind = arm.planner.chain, number % 8
    low, high = chain_.low, chain_.high
    near = np.clip(arm.ready + dice.uniform(-NEAR_RAD, NEAR_RAD, 6), low, high)
    start = dice.uniform(low, high) if kind < 3 else near
    of = dice.uniform(low, high) if kind < 2 else np.clip(start + dice.normal(0, DRAG_RAD, 6), low, high)
    if kind in (5, 6, 7):
        of = np.clip(arm.ready + dice.uniform(-NEAR_RAD, NEAR_RAD, 6), low, high)
    case = {"start": rounded(start), "of": rounded(of), "scale": round(float(dice.uniform(0.05, 1.0)), 2)}
    if kind == 1:
        case["shift"] = rounded(dice.uniform(-0.6, 0.6, 3))
    elif kind == 6:
        case["joints"] = rounded(of + dice.normal(0, 0.5, 6))
    elif kind == 7:
        case["velocity"] = rounded(dice.uniform(-1, 1, 6) * chain_.velocity * 0.4)
    return case


def rounded(values):
    return [round(float(v), 4) for v in values]


def pose_in(arm, case):
    pose = arm.planner.chain.forward(np.array(case["of"]))
    pose[:3, 3] += case.get("shift", (0.0, 0.0, 0.0))
    return pose


def answers(arm, case):
    """Return what Python makes of a case, as `answers` of frontend/tests/motion_answers.ts does."""
    start, planner_ = np.array(case["start"]), arm.planner
    velocity = np.array(case.get("velocity", np.zeros(6)))
    told = {
        "tool": planner_.chain.forward(start).ravel().tolist(),
        "distances": planner_.zones.distances(start).tolist(),
    }
    try:
        if "joints" in case:
            target = np.array(case["joints"])
        else:
            target = planner_.reach(pose_in(arm, case), start)
            told["reached"] = target.tolist()
        path = planner_.joints(target, start, velocity, case["scale"]).path
        longest = arm.description["motion"]["limit_s"]
        if path.seconds > longest:
            raise Refused("range", too_long(path.seconds, longest))
    except Refused as error:
        return told | {"text": str(error), "code": error.code}
    return told | {"seconds": path.seconds, "third": path.at(path.seconds / 3)[0].tolist()}


def too_long(seconds, longest):
    """Return the sentence of `MotionPlanner`, which plans for arms that ship only."""
    return (
        f"the motion would take {seconds:.0f} s, longer than the {longest:g} s that one may take; "
        "ask for more of full speed, or go less far"
    )
