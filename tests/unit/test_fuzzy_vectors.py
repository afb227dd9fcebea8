"""The page's rules are the rover's: the same texts, speeds and refusals (frontend/tests/fuzzy.test.ts).

`PYTHONPATH=. .venv/bin/python -m tests.unit.test_fuzzy_vectors` writes the vectors anew.
"""

import json
import random
from dataclasses import replace
from pathlib import Path

from robots.kit.contract.errors import BadRequest
from robots.kit.description import load
from robots.kit.drivers.srv1.rules import READINGS, crc_of, rules_of
from robots.kit.rovers.fuzzy import LABELS, PAPER, RuleSet, Variable, speed
from robots.kit.rovers.fuzzy_text import LINES as LINES_MOST
from robots.kit.rovers.fuzzy_text import LONGEST, write

FILE = Path(__file__).resolve().parents[1] / "vectors" / "fuzzy.json"
NUMBER, CASES = 40, 12
LINES = ("method no", "input sonar m: A 1, B 2", "rule VN, VN: VS", "rule XX, N: S", "output speed m/s: A 1.2345", "#")
NOT_PRINTABLE = ("\x00", "\x1a", "\x04", "\t", "\r", "\x1f", "\x7f", "\x85", "\u00e9", "\u2028", "\U0001f600", "\ud800")


def drawn(dice):
    """Return a rule set with any readings, peaks, table and method."""
    names = dice.sample(sorted(READINGS), 2)
    inputs = [
        Variable(name, READINGS[name], LABELS, tuple(sorted(n / 1000 for n in dice.sample(range(-900, 12000), 5))))
        for name in names
    ]
    gaps = [dice.randrange(10, 110) for _ in range(4)]
    at = tuple((dice.randrange(30) + sum(gaps[:n])) / 1000 for n in range(5))
    output = (
        replace(PAPER.output, peaks=tuple(sorted({min(v, 0.5) for v in at}))) if len(set(at)) == 5 else PAPER.output
    )
    table = tuple(tuple(dice.randrange(5) for _ in range(5)) for _ in range(5))
    return RuleSet((inputs[0], inputs[1]), output, table, dice.choice(("sugeno", "mamdani")))


def near(variable, dice):
    low, high = variable.peaks[0], variable.peaks[-1]
    margin = (high - low) / 5
    return dice.choice((round(dice.uniform(low - margin, high + margin), 4), dice.choice(variable.peaks)))


def refusal(text):
    """Return why the rover refuses a text; empty if it does not."""
    try:
        rules_of(text)
    except BadRequest as error:
        return str(error)
    return ""


def vectors():
    dice = random.Random(6)
    sets = [PAPER, replace(PAPER, method="mamdani")]
    while len(sets) < NUMBER:
        try:
            sets.append(drawn(dice))
        except ValueError:
            continue
    told = []
    for rules in sets:
        cases = [tuple(near(v, dice) for v in rules.inputs) for _ in range(CASES)]
        text = write(rules)
        told.append(
            {
                "text": text, "crc": crc_of(text), "refusal": refusal(text),
                "cases": [[a, b, speed(rules, a, b)] for a, b in cases],
            }
        )  # fmt: skip
    paper = write(PAPER)
    mended = [
        paper.replace("rule M, M: M\n", ""), paper.replace("N 0.3,", "N 0.15,"), paper.replace("VF 0.4", "VF 0.6"),
        paper.replace("VF 0.4", "VF 0.325"), paper.replace("input sonar m", "input sonar V"),
        paper.replace("input sonar m", "input depth m"), paper.replace("rule N, VF: S", "rule N, VF: VF"),
        paper.replace("VS 0.08, S 0.16, M 0.24, F 0.32, VF 0.4", "VS 0.1, S 0.2, M 0.3, F 0.4, VF 0.5"),
        paper + "rule M, M: M\n", paper.replace("\n", "\r\n"), "x" * 3000, "", *(line + "\n" + paper for line in LINES),
        paper.replace("N 0.3,", "N 0.3\r,"), paper.replace("N 0.3,", "N 0.3\u2028,"), "# \u2028\n" + paper,
        *("#" * (LONGEST - len(paper) - 1 + more) + "\n" + paper for more in (0, 1)),
        *("#\n" * (LINES_MOST - 1 - paper.count("\n") + more) + paper for more in (0, 1)),
        "# %h*EDAE\n" + paper, *(f"# a{letter}b\n" + paper for letter in NOT_PRINTABLE),
    ]  # fmt: skip
    made = load("srv1")
    return {
        "made": {name: made[name] for name in ("body", "motion", "infrared")}, "sets": told,
        "texts": [{"text": text, "refusal": refusal(text)} for text in mended],
    }  # fmt: skip


def test_the_vectors_are_what_the_rover_gives():
    told, made = json.loads(FILE.read_text()), vectors()
    assert [one["text"] for one in told["sets"]] == [one["text"] for one in made["sets"]]
    for old, new in zip(told["sets"], made["sets"], strict=True):
        assert (old["crc"], old["refusal"]) == (new["crc"], new["refusal"])
        assert all(abs(a[2] - b[2]) < 1e-12 for a, b in zip(old["cases"], new["cases"], strict=True))
    assert (told["texts"], told["made"]) == (made["texts"], made["made"])


def test_the_vectors_have_both():
    told = json.loads(FILE.read_text())
    refused = [bool(one["refusal"]) for one in told["sets"] + told["texts"]]
    assert 5 < sum(refused) < len(refused) - 2


if __name__ == "__main__":
    FILE.write_text(json.dumps(vectors(), separators=(",", ":")) + "\n")
