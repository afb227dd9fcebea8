"""Runs the tests of `make test`, or with `all` those of `make test-all`; goes on after a failure and names each.

First what judges by fractions of a second: two files side by side, then one after another what loads the machine
itself (in `make test-all` each test alone, because the iRat's need a whole core); then everything else, several files
side by side, on both databases at once. Beside both, at the lowest priority, what only computes: the unit tests, and
the rules that ask no clock. A test that only waited too long is tried once more and named; a wrong answer is not, nor
a measured time over its limit.
"""

import os
import subprocess
import sys
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TOO_LONG = ("not within", "(?i)timeout", "LineSilent")  # what a test says that has waited, here or in a driver
PATIENT = ("--reruns", "1", *(part for said in TOO_LONG for part in ("--only-rerun", said)))
BESIDE = ("--dist", "loadfile", "--no-loadscope-reorder")
COMPUTING = ("tests/unit",)  # what asks no clock may be kept waiting for as long as it takes
RULES = ("tests/services", "tests/security")
DATABASES = ("postgres", "sqlite")
WAITING = ("tests", *(f"--ignore={room}" for room in COMPUTING))
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

    def argv(self) -> list[str]:
        """Return the command line."""
        beside = ["-n", str(self.workers), *BESIDE] if self.workers else []
        aside = [sys.executable, str(ROOT / "tools" / "aside.py")] if self.aside else []
        return [*aside, sys.executable, "-m", "pytest", *self.files(), *beside, *PATIENT, "-m", self.marks]


Lane = tuple[Part, ...]  # one after another


@dataclass(frozen=True)
class Run:
    """What is run: `computing` beside everything else, `lone` tests with nothing but that, then `rest` side by side."""

    computing: Lane
    lone: Lane
    rest: tuple[Lane, ...]


SOME = Run(
    computing=(
        Part("sqlite", COMPUTING, SHORT, workers=2, aside=True),
        *(Part(database, RULES, f"computes and {SHORT}", workers=2, aside=True) for database in DATABASES),
    ),
    lone=(
        Part("sqlite", ("tests",), "alone and not loads and not length", workers=2, naming=("alone",)),
        Part("sqlite", ("tests",), "loads and not length", naming=("loads",)),
        Part("postgres", ("tests",), "tenth and alone and not length", naming=("tenth",)),
    ),
    rest=(
        (Part("sqlite", WAITING, f"not computes and {SHORT}", workers=6),),
        (Part("postgres", ("tests",), f"{BOTH} and {SHORT}", workers=1, naming=("service", "tenth")),),
    ),
)
ALL = Run(
    computing=(
        *(Part(database, COMPUTING, "not alone", workers=2, aside=True) for database in DATABASES),
        *(Part(database, RULES, "computes and not alone", workers=2, aside=True) for database in DATABASES),
    ),
    lone=tuple(Part(database, ("tests",), "alone") for database in DATABASES),
    rest=tuple((Part(database, WAITING, "not computes and not alone", workers=3),) for database in DATABASES),
)


def keeping_bytecode(environ: Mapping[str, str]) -> dict[str, str]:
    """Return an environment in which hundreds of processes do not each compile the same sources again."""
    return {name: value for name, value in environ.items() if name != "PYTHONDONTWRITEBYTECODE"}


def run(lane: Lane, shown: bool) -> list[str]:
    """Run the parts of a lane; return the names of those that failed. `shown`: print what they say as they go."""
    failed = []
    for part in lane:
        since = time.monotonic()
        env = {**keeping_bytecode(os.environ), "FARHAND_TEST_DB": part.database, "PYTHONPATH": "."}
        to = {} if shown else {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        done = subprocess.run(part.argv(), env=env, text=True, errors="replace", check=False, **to)
        sys.stdout.write(f"{done.stdout or ''}=== {part.name}: {time.monotonic() - since:.0f} s\n\n")
        sys.stdout.flush()
        if done.returncode:
            failed.append(part.name)
    return failed


def main() -> int:
    """Run everything; return the exit status."""
    chosen = ALL if sys.argv[1:] == ["all"] else SOME
    with ThreadPoolExecutor() as side_by_side:
        computed = side_by_side.submit(run, chosen.computing, shown=False)
        try:
            failed = run(chosen.lone, shown=True)
            ended = [side_by_side.submit(run, lane, shown=lane is chosen.rest[0]) for lane in chosen.rest]
            failed += [name for lane in (*ended, computed) for name in lane.result()]
        except KeyboardInterrupt:
            os._exit(130)  # what runs aside ends with this process
    for name in failed:
        sys.stdout.write(f"FAILED: {name}\n")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
