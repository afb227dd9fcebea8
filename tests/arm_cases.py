"""Motions of an arm that Python and the browser both plan: cases, and what Python makes of them."""

import json
import subprocess
from dataclasses import dataclass
from typing import Any

import numpy as np

from robots.kit.arms.chain import Chain, Joint
from robots.kit.arms.described import chain, motion_facts, planner, posture
from robots.kit.arms.motions import refuse_long
from robots.kit.arms.path import Limits
from robots.kit.arms.planner import Planner, Refused
from robots.kit.arms.zones import Box, Limb, Zones
from robots.kit.description import load
from tools.setup import FRONTEND, find_node

NEAR_RAD = 0.4  # of motions above the table, which boxes seldom end
DRAG_RAD = 0.02  # of one step of a ghost
# Lengths as in the PUMA's description, in the usual form of Denavit and Hartenberg, where each axis is z of its frame.
DENAVIT = ((0.0, np.pi / 2, 0.6718), (0.4318, 0.0, 0.0), (0.0203, -np.pi / 2, 0.15005), (0.0, np.pi / 2, 0.4318), (0.0, -np.pi / 2, 0.0), (0.0, 0.0, 0.15))  # fmt: skip
RANGES = (160, 110, 135, 266, 100, 266)  # degrees to each side


@dataclass
class Arm:
    """An arm to plan for, what the browser is told of it, and joints above its table."""

    planner: Planner
    facts: dict[str, Any]
    ready: Any


def shipped(driver):
    """Return an arm that ships with the house."""
    described = load(driver)
    return Arm(planner(driver), motion_facts(described, chain(driver)), posture(described, "ready"))


def told(facts, ready):
    """Return the arm of which the browser is told this."""
    joints = tuple(
        Joint(
            j["name"], np.array(j["origin"]).reshape(4, 4), np.array(j["axis"]), j["low"], j["high"], j["velocity"], 0.0
        )
        for j in facts["joints"]
    )
    motion = facts["motion"]
    arm = Chain(joints, np.array(motion["tool"]).reshape(4, 4))
    zones = Zones(arm, [Limb(**limb) for limb in motion["limbs"]], [Box(**box) for box in facts["boxes"]])
    made = Planner(arm, zones, Limits.of(arm, motion["acceleration_s"]), motion["clearance_m"])
    return Arm(made, facts, np.array(ready))


def by_denavit():
    """Return an arm of the PUMA's shape whose joints' frames are turned against each other."""
    links, before = ["<link name='l0'/>"], "xyz='0 0 0'"
    for n, ((a, alpha, d), high) in enumerate(zip(DENAVIT, np.radians(RANGES), strict=True), 1):
        limits = f"<limit lower='{-high}' upper='{high}' velocity='{1 + n / 4}' effort='1'/>"
        links.append(
            f"<link name='l{n}'/><joint name='J{n}' type='revolute'><parent link='l{n - 1}'/><child link='l{n}'/>"
            f"<origin {before}/><axis xyz='0 0 1'/>{limits}</joint>"
        )
        before = f"xyz='{a} 0 {d}' rpy='{alpha} 0 0'"
    end = f"<joint name='tip' type='fixed'><parent link='l6'/><child link='tip'/><origin {before}/></joint>"
    described = {
        "motion": load("puma")["motion"],
        "box": [{"name": "the table", "low": [-1.2, -1.2, -0.8], "high": [1.2, 1.2, 0.0]}],
        "limb": [
            {"name": "upper arm", "joint": "J2", "begin": [0.0, 0.0, 0.0], "end": [0.4318, 0.0, 0.0], "radius": 0.1},
            {"name": "hand", "joint": "J6", "begin": [0.0, 0.0, 0.0], "end": [0.0, 0.0, 0.1], "radius": 0.05},
        ],
    }
    arm = Chain.from_urdf(f"<robot name='denavit'>{''.join(links)}<link name='tip'/>{end}</robot>", "tip")
    return told(motion_facts(described, arm), [0.3, 0.5, -0.4, 0.2, 0.9, 0.1])


ARMS = {"pa10": lambda: shipped("pa10"), "puma": lambda: shipped("puma"), "denavit": by_denavit}


def singular_joints(arm, dice, kind):
    """Return joints at a singular pose: the wrist straight, the elbow stretched, or the wrist nearest to the first axis."""
    found = dice.uniform(arm.low, arm.high)
    if kind == "wrist":
        found[4] = 0.0
    elif kind == "elbow":
        found[2] = least(lambda tried: -from_second_axis(arm, tried), arm.low[2], arm.high[2])
    else:
        found[1] = least(
            lambda tried: np.linalg.norm(wrists(arm, found, 1, tried)[:, :2], axis=1), arm.low[1], arm.high[1]
        )
    return found


def wrists(arm, q, joint, angles):
    """Return where the wrist's centre is (m) with one joint at each of the angles."""
    rows = np.tile(q, (len(angles), 1))
    rows[:, joint] = angles
    return arm.frames(rows)[:, 4, :3, 3]


def from_second_axis(arm, thirds):
    """Return how far the wrist's centre is from the second axis (m) for angles of the third."""
    frames = arm.frames(np.zeros(6))
    off = wrists(arm, np.zeros(6), 2, thirds) - frames[1, :3, 3]
    return np.linalg.norm(np.cross(off, frames[1, :3, :3] @ arm.joints[1].axis), axis=1)


def least(cost, low, high):
    """Return where in a range a function is least, to about 1e-8."""
    for _ in range(14):
        tried = np.linspace(low, high, 60)
        best = int(np.clip(np.argmin(cost(tried)), 1, 58))
        low, high = tried[best - 1], tried[best + 1]
    return (low + high) / 2


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
        case["scale"] = 0.05 if number % 16 == 6 else case["scale"]
    elif kind == 7:
        case["velocity"] = rounded(dice.uniform(-1, 1, 6) * chain_.velocity * 0.4)
    return case


def rounded(values):
    return [round(float(v), 4) for v in values]


def pose_in(arm, case):
    pose = arm.planner.chain.forward(np.array(case["of"]))
    pose[:3, 3] += case.get("shift", (0.0, 0.0, 0.0))
    return pose


def in_browser(arm, cases, plans=True, times=False):
    """Return what the browser's planner makes of the cases, run by Node: answers, and its times (microseconds)."""
    script = FRONTEND / "tests" / "motion_answers.ts"
    asked = json.dumps({"facts": arm.facts, "cases": cases, "plans": plans, "times": times})
    done = subprocess.run([find_node() / "node", script], input=asked, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    return found["answers"], found["us"]


def answers(arm, case):
    """Return what Python makes of a case, as `answers` of frontend/tests/motion_answers.ts does."""
    start, planner_ = np.array(case["start"]), arm.planner
    velocity = np.array(case.get("velocity", np.zeros(6)))
    found = {
        "tool": planner_.chain.forward(start).ravel().tolist(),
        "distances": planner_.zones.distances(start).tolist(),
    }
    try:
        if "joints" in case:
            target = np.array(case["joints"])
        else:
            target = planner_.reach(pose_in(arm, case), start)
            found["reached"] = target.tolist()
        path = planner_.joints(target, start, velocity, case["scale"]).path
        refuse_long(path.seconds, arm.facts["motion"]["limit_s"])
    except Refused as error:
        return found | {"text": str(error), "code": error.code}
    return found | {"seconds": path.seconds, "third": path.at(path.seconds / 3)[0].tolist()}
