"""The report of a proof: numbers wanted and run, and the measured figure."""

import json
import os
import re
import time
from pathlib import Path

FULL = os.environ.get("FARHAND_PROOFS") == "full"
# more examples than `make test` has time for: in `make test-all`, and where variants of the code are to be found broken
AT_LENGTH = FULL or bool({"FARHAND_AT_LENGTH", "FARHAND_MUTANT"} & os.environ.keys())


class Proof:
    """One test's part of a promise's proof."""

    def __init__(self, test, promise):
        self.test, self.promise = test, promise
        self._counts = []

    @classmethod
    def at(cls, node):
        """Return the proof of a test that is named after its promise."""
        return cls(f"{Path(str(node.path)).name}::{node.name}", int(re.match(r"test_promise_(\d+)", node.name)[1]))

    def count(self, what, small, full, asked=None):
        """Return how many to run; `asked` is the promise's own number where this machine is too small."""
        number = full if FULL else small
        self._counts.append({"what": what, "ran": number, "asked": asked or full})
        return number

    def holds(self, figure):
        """Say that the promise held, and the figure; called last, after every assertion."""
        folder = os.environ.get("FARHAND_PROOFS_TO")
        line = {"promise": self.promise, "test": self.test, "figure": figure, "counts": self._counts, "full": FULL,
                "at": time.strftime("%Y-%m-%d"), "database": os.environ.get("FARHAND_TEST_DB", "sqlite")}  # fmt: skip
        print(json.dumps(line))
        if folder:
            with (Path(folder) / "proofs.jsonl").open("a") as out:
                out.write(json.dumps(line) + "\n")
