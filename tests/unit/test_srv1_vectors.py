"""Missions that Python and TypeScript judge alike: `tests/vectors/missions.json`, which a Node test reads, too."""

import json
import random
from pathlib import Path

from robots.kit.contract.errors import BadRequest
from robots.kit.description import load
from robots.kit.drivers.srv1.hall import hall
from robots.kit.drivers.srv1.missions import judge, parse, write

FILE = Path(__file__).parents[1] / "vectors" / "missions.json"
TEXTS = (
    "go nowhere", "turn 400", "wait", "dance", "say", "patrol 0", "go 1 2 3", "look", "photograph twice", "go -1 2",
    "", "# words\n", "read\n" * 61, "go 1e1 2e0 x", "turn nan", "wait 1e308", "go 0x10 1", "turn 90 degrees", "go",
    # lines: a feed alone ends one, and no letter may look as if it did
    *(f"say Hello{odd}go East" for odd in "\x00\x0b\x0c\x1c\x1d\x1e\x85\u2028\u2029\x1b\x7f\x9f\u202e\u2067\ud800"),
    "read\r\nphotograph\r\n", "read\rphotograph", "read\r", "# a\u2028go East\nread", "# \ud800\nphotograph", "# \x00\nread",
    "\ufeffread", "say \ufeff", "\u2028", "say tab\tstop", "\t read \t", "read \u00a0", "\u3000read", "go\tSouth", "look  around",
    # letters of words
    "say Bon\u00a0soir \u00e0 tous", "say \U0001f468\u200d\U0001f469\u200d\U0001f467 \U0001f600", "say \u0663 \u05e9\u05dc\u05d5\u05dd", "say \u00a0",
    # numbers
    "wait 1_0", "wait \u0663", "wait \uff11\uff12", "wait +5.", "wait .5e1", "turn -0", "wait 1e-9", "turn 0.0005", "turn -0.0005",
    "wait 2.0005", "wait 0.0625", "go 1\u00a02", "go 1.23456 2.9999", "go \u0663 1", "go 1,5 2", "patrol 0.9999", "turn 360.0001",
    "wait Infinity", "wait 1e999", "turn - 5", "go south", "go SOUTH", "go \u017fouth", "go 1 2 # there", "wait 119.99999",
    # lengths
    "say " + "\U0001f600" * 156, "say " + "\U0001f600" * 157, "say " + "a" * 157, *("#" + "\U0001f600" * n + "\nread" for n in (3994, 3995)),
    "read\n" * 60, "\U0001f600" * 50,
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
    return {"tables": tables, "missions": missions, "texts": [{"text": text, **read(text)} for text in TEXTS]}


def read(text: str) -> dict[str, str]:
    """Return what a text says, written anew, or why it is no mission."""
    try:
        return {"written": write(parse(text)).strip()}
    except BadRequest as error:
        return {"refusal": str(error)}


def test_the_vectors_are_what_python_judges():
    assert json.loads(FILE.read_text()) == json.loads(json.dumps(generated())), "write them anew: see below"


def test_the_vectors_have_texts_of_both_kinds():
    refused = [one for one in json.loads(FILE.read_text())["texts"] if "refusal" in one]
    assert 20 < len(refused) < len(TEXTS) - 20
    assert all(one["refusal"].endswith(".") for one in refused)


if __name__ == "__main__":
    FILE.write_text(json.dumps(generated(), indent=1) + "\n")
