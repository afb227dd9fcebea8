"""The browser plans an arm's motions as Python does (frontend/src/motion, frontend/tests/motion.test.ts).

`PYTHONPATH=. .venv/bin/python -m tests.unit.test_arm_motion_vectors` writes the vectors anew.
"""

import json
from pathlib import Path

import numpy as np
import pytest

from robots.kit.arms.planner import Refused
from tests.arm_cases import ARMS, answers, drawn, in_browser, pose_in, singular_joints, told
from tests.conftest import at_length

FILE = Path(__file__).resolve().parents[1] / "vectors" / "arm_motions.json"
DRIVERS, CASES, WHOLE = ("pa10", "puma"), 200, 20
NUMBERS = (
    0.0, -0.0, 0.05, -0.04, 0.25, 0.35, -0.75, 2.5, 3.5, 0.125, 1.005, 99.95, 165.0003, 1e6, -1.5e7, 123456.0, 1234567.0,
    1e21, 1e300, 5e-324, 0.0001, 0.00001234, 999.9996, 0.1 + 0.2, -1e-9,
)  # fmt: skip
M, RAD, S = 1e-6, 1e-6, 1e-6


def told_of(arm, case, whole):
    """Return a case with what Python makes of it, rounded to the digits that matter."""
    found = answers(arm, case)
    short = {"reached": [round(v, 8) for v in found["reached"]]} if "reached" in found else {}
    if "text" in found:
        short |= {"text": found["text"], "code": found["code"]}
    else:
        short |= {"seconds": round(found["seconds"], 8)}
    if whole:
        short |= {name: [round(v, 9) for v in found[name]] for name in ("tool", "distances", "third") if name in found}
    return case | {"answers": short}


def vectors(arms):
    """Return the vectors for {name: arm}; numbers in words as Python writes them."""
    made = {}
    for name, arm in arms.items():
        dice = np.random.default_rng(7)
        cases = [told_of(arm, drawn(arm, dice, n), n < WHOLE) for n in range(CASES)]
        made[name] = {"facts": arm.facts, "ready": arm.ready.tolist(), "cases": cases}
    words = [[v, f"{v:.0f}", f"{v:.1f}", f"{v:.3f}", f"{v:.3g}", f"{v:g}"] for v in NUMBERS]
    return {"arms": made, "words": words}


def test_the_vectors_are_what_python_plans():
    """For the arms as they stand in the vectors: those that ship may change."""
    kept = json.loads(FILE.read_text())
    made = vectors({name: told(one["facts"], one["ready"]) for name, one in kept["arms"].items()})
    assert kept["words"] == made["words"]
    for name, one in made["arms"].items():
        assert len(kept["arms"][name]["cases"]) == CASES
        for old, new in zip(kept["arms"][name]["cases"], one["cases"], strict=True):
            wanted, found = old.pop("answers"), new.pop("answers")
            assert old == new
            assert found.keys() == wanted.keys()
            for key in found:
                exact = isinstance(found[key], str)
                assert found[key] == (wanted[key] if exact else pytest.approx(wanted[key], abs=1e-7)), (name, old)


def test_the_vectors_have_all_outcomes():
    for one in json.loads(FILE.read_text())["arms"].values():
        texts = [case["answers"].get("text", "") for case in one["cases"]]
        for part in (
            "",
            "away: the arm is too short",
            "joint ",
            "there the ",
            "on the way there, after ",
            "would take",
        ):
            assert any(text.startswith(part) if part in ("", "joint ") else part in text for text in texts), part


@pytest.mark.parametrize("cases", [240, at_length(10_000)])
@pytest.mark.parametrize("name", ARMS)
def test_the_browser_plans_as_python_does(name, cases):
    """Same branch, same words; 0.001 mm, 0.0001 degrees, 0.000001 s."""
    arm = ARMS[name]()
    dice = np.random.default_rng((cases, len(name)))
    asked = [drawn(arm, dice, n) for n in range(cases)]
    found, times = in_browser(arm, asked, times=True)
    print(f"{name}: median and 99th percentile of the processor's microseconds {times}")
    for case, there in zip(asked, found, strict=True):
        here = answers(arm, case)
        assert there.get("text", "") == here.get("text", ""), case
        assert there.get("code", "") == here.get("code", ""), case
        assert there.keys() == here.keys(), case
        for key, within in {"tool": M, "distances": M, "reached": RAD, "third": RAD, "seconds": S}.items():
            if key in here:
                assert there[key] == pytest.approx(here[key], abs=within, rel=0), (key, case)


@pytest.mark.parametrize("kind", ["wrist", "elbow", "shoulder"])
@pytest.mark.parametrize("name", ARMS)
def test_at_singular_poses_the_browser_finds_an_answer_as_near(name, kind):
    """Where the wrist stands above the first axis only some answer is wanted: they are a curve."""
    arm = ARMS[name]()
    chain, dice = arm.planner.chain, np.random.default_rng(11)
    asked = []
    for number in range(60):
        q = singular_joints(chain, dice, kind)
        near = np.clip(q + dice.normal(0, 0.02, 6), chain.low, chain.high)
        start = dice.uniform(chain.low, chain.high) if number % 2 else near
        asked.append({"start": start.tolist(), "of": q.tolist(), "scale": 0.5})
    for case, there in zip(asked, in_browser(arm, asked, plans=False)[0], strict=True):
        start, pose = np.array(case["start"]), pose_in(arm, case)
        here = arm.planner.reach(pose, start)
        q = np.array(there["reached"])
        assert np.abs(chain.forward(q) - pose).max() < 3e-7
        assert chain.broken_limit(q) == ""
        if kind != "shoulder" or name == "puma":
            costs = [float(np.max(np.abs(one - start) / chain.velocity)) for one in (q, here)]
            assert costs[0] < costs[1] + 1e-5, (case, q, here)


@pytest.mark.parametrize("name", ARMS)
def test_of_equally_near_answers_the_one_whose_other_joints_move_less_is_taken(name):
    """Both ends of the wrist reach a pose; where the first joint is the slowest, either is as near."""
    arm = ARMS[name]()
    chain, dice, even = arm.planner.chain, np.random.default_rng(12), 0
    for _ in range(300):
        start, q = dice.uniform(chain.low, chain.high), dice.uniform(chain.low, chain.high)
        pose = chain.forward(q)
        try:
            chosen = arm.planner.reach(pose, start)
        except Refused:
            continue
        ways = np.abs(np.array(arm.planner.inverse.inside(pose)) - start) / chain.velocity
        equal = ways[ways.max(axis=1) <= ways.max(axis=1).min() + 1e-9]
        even += len(equal) > 1
        assert np.sum(np.square((chosen - start) / chain.velocity)) <= np.square(equal).sum(axis=1).min() + 1e-6
    assert even > 20


if __name__ == "__main__":
    FILE.write_text(json.dumps(vectors({name: ARMS[name]() for name in DRIVERS}), separators=(",", ":")) + "\n")
