"""The report of a proof: numbers wanted and run, the measured figure, and how it was measured."""

import json
import os
import re
import time  # noqa: TID251 - the date of a figure
from pathlib import Path

from tests import pace

FULL = os.environ.get("FARHAND_PROOFS") == "full"
# more examples than `make test` has time for: in `make test-all`, and where variants of the code are to be found broken
AT_LENGTH = FULL or bool({"FARHAND_AT_LENGTH", "FARHAND_MUTANT"} & os.environ.keys())
VIRTUAL, REAL = "virtual", "real"
SEEDS = "seeds"
SEED = re.compile(r"seed\d+-?")  # how a seed stands in pytest's name of a test
WITH_PROCESSES = ("drivers", "faults", "e2e")


def without_seed(test: str) -> str:
    """Return pytest's name of a test without its seed."""
    return SEED.sub("", test).replace("-]", "]").replace("[]", "")


class Proof:
    """One test's part of a promise's proof.

    `time` tells whose time passes: that of a clock that the test moves, or of the machine. `seeds`: with how many seeds
    the test is to run; all of them are one figure. `kept`: the folder into which it writes. The pace of the machine is
    measured where somebody reads it and it matters: with a folder, in real time.
    """

    def __init__(self, test, promise, time=VIRTUAL, seeds=0, kept=None, measured=pace.measured):
        self.test, self.promise, self.time = without_seed(test), promise, time
        self._folder = kept or os.environ.get("FARHAND_PROOFS_TO")
        self._measured = measured if self._folder and time == REAL else dict
        self._seeds = seeds or 1
        self._counts = [{"what": SEEDS, "ran": 1, "asked": seeds}] if seeds else []
        self._discarded = []
        self._before = self._measured()

    @classmethod
    def at(cls, node, **given):
        """Return the proof of a test that is named after its promise."""
        real = node.get_closest_marker("timed") or Path(str(node.path)).parent.name in WITH_PROCESSES
        promise = int(re.match(r"test_promise_(\d+)", node.name)[1])
        seeds = getattr(getattr(node, "function", None), "seeds", 0)
        return cls(f"{Path(str(node.path)).name}::{node.name}", promise, REAL if real else VIRTUAL, seeds, **given)

    def count(self, what, small, full, asked=None):
        """Return how many to run; `asked` is the promise's own number where this machine is too small."""
        number = full if FULL else small
        self._counts.append({"what": what, "ran": number, "asked": (asked or full) * self._seeds})
        return number

    def discards(self, number, why):
        """Say how many samples are not in the figure, and why."""
        self._discarded += [{"number": number, "why": why}] if number else []

    def holds(self, figure, worst=0.0):
        """Say that the promise held, and the figure; called last, after every assertion.

        Of several seeds the figure with the largest `worst` stays.
        """
        line = {"promise": self.promise, "test": self.test, "figure": figure, "worst": worst, "counts": self._counts, "full": FULL,
                "at": time.strftime("%Y-%m-%d"), "database": os.environ.get("FARHAND_TEST_DB", "sqlite"),
                "time": self.time, "discarded": self._discarded,
                "pace": {"before": self._before, "after": self._measured()}}  # fmt: skip
        print(json.dumps(line))
        if self._folder:
            with (Path(self._folder) / "proofs.jsonl").open("a") as out:
                out.write(json.dumps(line) + "\n")
