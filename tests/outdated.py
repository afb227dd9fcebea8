"""Which figures of the promises are older than the code that they rest on: a warning in `make check`, no failure."""

import sys
import tomllib
from collections import defaultdict
from collections.abc import Callable, Iterable

from tests import history, proofs

COVERED = proofs.ROOT / "tests" / "covered.toml"
Differs = Callable[[str, list[str]], list[str]]  # files below paths that differ from a commit


def covered() -> dict[int, list[str]]:
    """Return the files and folders that each promise's figures rest on."""
    return {int(number): paths for number, paths in tomllib.loads(COVERED.read_text()).items()}


def warnings(records: list[dict], paths: dict[int, list[str]], differs: Differs) -> list[str]:
    """Return a line for each promise with outdated figures, and for whatever cannot be told."""
    measured: dict[int, set[str]] = defaultdict(set)
    for record in records:
        measured[record["promise"]].add(record.get("commit", ""))
    told, unknown = [], defaultdict(set)
    for number, commits in sorted(measured.items()):
        files: set[str] = set()
        for commit in commits:
            short, _, mixed = commit.partition("+")
            if not short:
                unknown["their figures name no commit"].add(number)
                continue
            if mixed:
                unknown[f"measured at {short} with changes that are in no commit"].add(number)
            try:
                files.update(differs(short, paths.get(number, [])))
            except history.NoHistory as why:
                unknown[str(why)].add(number)
        if files:
            told.append(f"promise {number} was measured before changes of {some(files)}: make proofs P={number}")
    return told + [f"cannot tell of promises {', '.join(map(str, sorted(n)))}: {why}" for why, n in unknown.items()]


def some(files: Iterable[str], limit: int = 3) -> str:
    """Return the first names, and how many more there are."""
    first, rest = sorted(files)[:limit], sorted(files)[limit:]
    return ", ".join(first) + (f" and {len(rest)} more" if rest else "")


def main() -> None:
    """Print the warnings."""
    found = warnings(proofs.kept(), covered(), lambda since, paths: history.changed(proofs.ROOT, since, paths))
    sys.stdout.write("".join(f"warning: {line}\n" for line in found))


if __name__ == "__main__":
    main()
