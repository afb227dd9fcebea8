"""One step of the rover's 25 fuzzy rules beside simpful, scikit-fuzzy and pyfuzzylite: the same rules and readings.

The three want other numbers of numpy than the portal has; they run in an environment and a process of their own, by
`_fuzzy_peers`, in turns with ours. Processor time.
"""

import json
import subprocess
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from benchmarks._beside import environment
from benchmarks.stage import median, tell
from robots.kit.rovers.fuzzy import PAPER, mamdani, sugeno, surface

PEERS = Path(__file__).with_name("_fuzzy_peers.py")
ROUNDS, STEPS = 7, 20  # in turns; of ours over all readings in each
GRID = 21, 23
GOAL, EQUAL, ALIKE = 50.0, 1e-6, 0.003  # times; m/s: of means, and of centroids, which theirs sample


def main() -> None:
    """Compare surfaces, then time."""
    first, second, means = surface(PAPER, *GRID)
    centroids = surface(replace(PAPER, method="mamdani"), *GRID)[2]
    readings = [(a, b) for a in first.tolist() for b in second.tolist()]
    task = {
        "inputs": [v.peaks for v in PAPER.inputs], "output": PAPER.output.peaks, "table": PAPER.table,
        "readings": readings,
    }  # fmt: skip
    ours = {"ours, sugeno": sugeno, "ours, mamdani": mamdani}
    times: dict[str, list[float]] = {}
    python = environment("fuzzy") / "bin" / "python"
    with subprocess.Popen([python, PEERS], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as peers:
        furthest = compare(_asked(peers, task), means.ravel().tolist(), centroids.ravel().tolist())
        for _ in range(ROUNDS):  # a machine that is busy for a while is so for all
            for name, step in ours.items():
                begun = time.process_time()
                for _ in range(STEPS):
                    for a, b in readings:
                        step(PAPER, a, b)
                times.setdefault(name, []).append(1000 * (time.process_time() - begun) / STEPS / len(readings))
            for name, took in _asked(peers, "again").items():
                times.setdefault(name, []).append(took)
        peers.stdin.close()  # type: ignore[union-attr]
    rows = {name: median(found) for name, found in times.items()}
    for name, took in rows.items():
        print(f"{name}: {1000 * took:.1f} us, its surface at most {furthest.get(name, 0):.1e} m/s from ours")
    quickest = min(took for name, took in rows.items() if name not in ours)
    ratio = quickest / rows["ours, sugeno"]
    beside = {name: {"us": round(1000 * took, 2)} for name, took in rows.items()}
    tell("fuzzy_step", ratio, "times as fast as the quickest", f">= {GOAL:g}, the same surface", ratio >= GOAL, beside)


def compare(theirs: dict[str, list[float]], means: list[float], centroids: list[float]) -> dict[str, float]:
    """Return by how much each surface differs from ours at most (m/s). Raises AssertionError where it is another."""
    furthest = {}
    for name, speeds in theirs.items():
        exact = name.endswith("sugeno")
        ours = means if exact else centroids[:: len(centroids) // 24]
        furthest[name] = max(abs(a - b) for a, b in zip(speeds, ours, strict=True))
        assert furthest[name] <= (EQUAL if exact else ALIKE), (name, furthest[name])
    return furthest


def _asked(peers: "subprocess.Popen[str]", what: Any) -> dict[str, Any]:
    assert peers.stdin and peers.stdout
    peers.stdin.write(json.dumps(what) + "\n")
    peers.stdin.flush()
    answer: dict[str, Any] = json.loads(peers.stdout.readline())
    return answer


if __name__ == "__main__":
    main()
