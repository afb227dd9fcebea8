"""Runs the tests of `make test`, or with `all` those of `make test-all`; goes on after a failure and names each.

First what judges by fractions of a second: two files side by side, then one after another what loads the machine
itself (in `make test-all` each test alone, because the iRat's need a whole core); then everything else, several files
side by side, those of the browser in a run of their own, on both databases at once. Beside both, at the lowest
priority, what only computes: the unit tests, and the rules that ask no clock.

At the end, with nothing beside it, a test that only waited too long is run once more and named; so is one that failed
in a crowd, where more runs than the cores can do in time: the answer that it gives alone counts. Another wrong answer,
or a measured time over its limit, beside what computes has to be right two times then. In `make test-all` it is final;
only on a machine that computes much slower than the one for which limits and numbers here were chosen, whatever failed
is run again. Fewer files run side by side there.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TOO_LONG = re.compile("not within|timeout|LineSilent", re.IGNORECASE)  # said by what waited, here or in a driver
AGAIN_AT_MOST = 8  # more failures than that are not the machine's
ORDINARY_S = 0.065  # what `pace` measures on two ordinary cores
SLOW = 1.5
BESIDE = ("--dist", "loadfile", "--no-loadscope-reorder")
COMPUTING = ("tests/unit",)  # what asks no clock may be kept waiting for as long as it takes
RULES = ("tests/services", "tests/security")
DATABASES = ("postgres", "sqlite")
PYTEST = (sys.executable, "-m", "pytest")
WAITING = ("tests", *(f"--ignore={room}" for room in COMPUTING))
BROWSER = ("tests/e2e",)  # by itself, so that browsers and robots run on from one file to the next
OTHERS = (*WAITING, *(f"--ignore={room}" for room in BROWSER))
SHORT = "not alone and not length"
BOTH = "(service or tenth) and not computes"


@dataclass(frozen=True)
class Part:
    """One run of pytest: `marks` chooses tests, `workers` run that many files side by side (0: one after another)."""

    database: str
    rooms: tuple[str, ...]
    marks: str
    workers: int = 0
    aside: bool = False  # runs only while nothing else wants the processor
    crowded: bool = False  # more runs side by side than the cores can do in time
    twice: bool = False  # what fails may pass all the same, if it does so two times with nothing beside it
    naming: tuple[str, ...] = ()  # only files that name one of these marks are read, because reading all takes long

    @property
    def name(self) -> str:
        """Return what it runs."""
        return f"{self.database}: {' '.join(self.rooms)}: {self.marks}"

    def files(self) -> tuple[str, ...]:
        """Return the rooms, or the files in them that name one of the marks."""
        if not self.naming:
            return self.rooms
        found = sorted(file for room in self.rooms for file in (ROOT / room).rglob("test_*.py"))
        wanted = [f for f in found if any(f"mark.{name}" in f.read_text() for name in self.naming)]
        return tuple(str(file.relative_to(ROOT)) for file in wanted)

    def argv(self, pace: float) -> list[str]:
        """Return the command line, for a machine that is so many times slower than an ordinary one."""
        workers = min(self.workers, max(2, round(self.workers / pace)))
        beside = ["-n", str(workers), *BESIDE] if workers else []
        aside = [sys.executable, str(ROOT / "tools" / "aside.py")] if self.aside else []
        return [*aside, *PYTEST, *self.files(), *beside, "-m", self.marks]


Lane = tuple[Part, ...]  # one after another


@dataclass(frozen=True)
class Run:
    """What is run: `computing` beside everything else, `lone` tests with nothing but that, then `rest` side by side."""

    computing: Lane
    lone: Lane
    rest: tuple[Lane, ...]
    longest_s: int  # a test that takes longer hangs, and is ended


SOME = Run(
    computing=(
        Part("sqlite", (*COMPUTING, *RULES), f"computes and not once and {SHORT}", workers=2, aside=True, twice=True),
        Part("postgres", RULES, f"computes and {SHORT}", workers=2, aside=True, twice=True),
    ),
    lone=(
        Part("sqlite", ("tests",), "alone and not loads and not length", workers=2, twice=True, naming=("alone",)),
        Part("sqlite", ("tests",), "loads and not length", twice=True, naming=("loads",)),
        Part("postgres", ("tests",), "tenth and alone and not length", twice=True, naming=("tenth",)),
    ),
    rest=(
        (Part("sqlite", BROWSER, SHORT, workers=2, crowded=True),),
        (Part("sqlite", OTHERS, f"not computes and not once and {SHORT}", workers=3, crowded=True),),
        (Part("postgres", ("tests",), f"{BOTH} and {SHORT}", workers=1, crowded=True, naming=("service", "tenth")),),
    ),
    longest_s=300,
)
ALL = Run(
    computing=tuple(
        Part(database, (*COMPUTING, *RULES), "computes and not alone", workers=2, aside=True) for database in DATABASES
    ),
    lone=tuple(Part(database, ("tests",), "alone") for database in DATABASES),
    rest=tuple((Part(database, WAITING, "not computes and not alone", workers=3),) for database in DATABASES),
    longest_s=3600,
)


def keeping_bytecode(environ: Mapping[str, str]) -> dict[str, str]:
    """Return an environment in which hundreds of processes do not each compile the same sources again."""
    return {name: value for name, value in environ.items() if name != "PYTHONDONTWRITEBYTECODE"}


def pace() -> float:
    """Return how many times slower than an ordinary machine this one computes, over about a second."""
    times = 10
    since = time.monotonic()
    for _ in range(times):
        sum(i * i for i in range(10**6))
    return (time.monotonic() - since) / times / ORDINARY_S


@dataclass(frozen=True)
class Failure:
    """One test that failed, and the last thing that it said; no test: the run itself failed."""

    part: Part
    test: str
    said: str


class Runner:
    """Runs parts, on a machine that is so many times slower than an ordinary one."""

    def __init__(self, slower: float, longest_s: int, folder: Path = ROOT) -> None:
        self._slower, self._longest_s, self._folder = slower, longest_s, folder

    def run(self, lane: Lane, shown: bool) -> list[Failure]:
        """Run the parts of a lane; return what failed. `shown`: print what they say as they go."""
        return [failure for part in lane for failure in self._pytest(part, part.argv(self._slower), part.name, shown)]

    def again(self, failures: list[Failure]) -> list[Failure]:
        """Run again, alone, what may have failed because of the machine; return what still fails.

        Once what waited too long or failed in a crowd, two times a wrong answer.
        """
        if not 0 < len(failures) <= AGAIN_AT_MOST:
            return failures
        slow = max(self._slower, pace()) > SLOW
        excused = [f for f in failures if f.part.crowded or TOO_LONG.search(f.said)]
        if not all(f.test and (slow or f.part.twice or f in excused) for f in failures):
            return failures
        still = []
        for part in dict.fromkeys(f.part for f in failures):
            wrong = dict.fromkeys(f.test for f in failures if f.part == part and f not in excused)
            tests = dict.fromkeys(f.test for f in failures if f.part == part)
            for test in tests:
                sys.stdout.write(f"AGAIN, alone: {part.database}: {test}\n")
            found = self._pytest(part, [*PYTEST, *tests], f"{part.database}: once more", shown=True)
            if wrong and not found:
                found = self._pytest(part, [*PYTEST, *wrong], f"{part.database}: a second time", shown=True)
            still += found
        return still

    def _pytest(self, part: Part, argv: list[str], name: str, shown: bool) -> list[Failure]:
        since = time.monotonic()
        with tempfile.NamedTemporaryFile("r", prefix="fh-failed-") as noted:
            env = {**keeping_bytecode(os.environ), "FARHAND_TEST_DB": part.database, "PYTHONPATH": str(ROOT)}
            env["PYTEST_TIMEOUT"] = str(self._longest_s)
            to = {} if shown else {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
            argv = [*argv, "-p", "tests.failed", "--failed-to", noted.name]
            done = subprocess.run(argv, cwd=self._folder, env=env, text=True, errors="replace", check=False, **to)
            failed = [Failure(part, **json.loads(line)) for line in noted]
        sys.stdout.write(f"{done.stdout or ''}=== {name}: {time.monotonic() - since:.0f} s\n\n")
        sys.stdout.flush()
        return failed or ([Failure(part, "", f"exit status {done.returncode}")] if done.returncode else [])


def main() -> int:
    """Run everything; return the exit status."""
    chosen = ALL if sys.argv[1:] == ["all"] else SOME
    if chosen is ALL:
        os.environ["FARHAND_AT_LENGTH"] = "1"
    slower = pace()
    sys.stdout.write(f"this machine takes {slower:.1f} times as long as an ordinary one\n")
    sys.stdout.flush()
    runner = Runner(slower, chosen.longest_s)
    with ThreadPoolExecutor() as side_by_side:
        computed = side_by_side.submit(runner.run, chosen.computing, shown=False)
        try:
            failures = runner.run(chosen.lone, shown=True)
            ended = [side_by_side.submit(runner.run, lane, shown=lane is chosen.rest[0]) for lane in chosen.rest]
            failures += [failure for lane in (*ended, computed) for failure in lane.result()]
            failures = runner.again(failures)
        except KeyboardInterrupt:
            os._exit(130)  # what runs aside ends with this process
    for failure in failures:
        sys.stdout.write(f"FAILED: {failure.part.name}: {failure.test} {failure.said[:200]}\n")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
