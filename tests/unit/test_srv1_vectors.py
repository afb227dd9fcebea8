"""Missions that Python and TypeScript judge alike: `tests/vectors/missions.json`, which a Node test reads, too."""

import json
import random
from pathlib import Path

import pytest

from robots.contract.errors import BadRequest
from robots.description import load
from robots.drivers.srv1.hall import hall
from robots.drivers.srv1.missions import judge, parse, write

FILE = Path(__file__).parents[1] / "vectors" / "missions.json"
BAD = (
    "go nowhere", "turn 400", "wait", "dance", "say", "patrol 0", "go 1 2 3", "look", "photograph twice", "go -1 2",
    "", "# words\n", "read\n" * 61, "go 1e1 2e0 x", "turn nan", "wait 1e308", "go 0x10 1", "turn 90 degrees", "go",
)  # fmt: skip


def generated() -> dict:
    """Return the vectors: the description's tables, missions with their verdict, and texts that are none."""
    dice, nodes, made = random.Random(7), [node.name for node in hall().nodes], load("srv1")

    def line() -> str:
        x, y = round(dice.uniform(0, 12), 2), round(dice.uniform(0, 8), 2)
        return dice.choice((
            f"go {dice.choice(nodes)}", f"go {dice.choice(nodes)}", f"go {x:g} {y:g}", f"turn {dice.randint(-360, 360)}",
            f"wait {dice.randint(0, 120)}", f"patrol {dice.randint(1, 120)}", "look around", "photograph", "read",
            "say Here begins the tour.",
        ))  # fmt: skip

    missions = []
    for _ in range(60):
        text = "\n".join(line() for _ in range(dice.randint(1, 14)))
        free = [(a, b) for a in range(13) for b in range(9) if hall().distance(a, b) > 0.4]
        here = (*map(float, dice.choice(free)), round(dice.uniform(-3, 3), 2))
        steps = parse(text)
        legs, said = judge(steps, here)
        missions.append({
            "text": text, "here": here, "written": write(steps).strip(),
            "legs": [
                {"step": leg.step, "end": [round(v, 6) for v in leg.poses[-1]], "corners": len(leg.poses),
                 "seconds": round(leg.seconds, 6), "least": round(leg.least_s, 6)}
                for leg in legs
            ],
            "said": [
                {"step": one.step, "at_s": round(one.at_s, 6), "text": one.text, "refuses": one.refuses} for one in said
            ],
        })  # fmt: skip
    tables = {name: made[name] for name in ("hall", "mission", "motion")}
    return {"tables": tables, "missions": missions, "bad": list(BAD)}


def test_the_vectors_are_what_python_judges():
    assert json.loads(FILE.read_text()) == json.loads(json.dumps(generated())), "write them anew: see below"


@pytest.mark.parametrize("text", BAD)
def test_what_is_no_mission_is_refused_here_too(text):
    with pytest.raises(BadRequest):
        parse(text)


if __name__ == "__main__":
    FILE.write_text(json.dumps(generated(), indent=1) + "\n")
