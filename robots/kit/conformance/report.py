"""The report of the suite: the result of each check, in sentences for the author of the driver."""

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from enum import StrEnum

MOST = 4  # faults of one check that are told; the next ones are counted
WIDE = 16  # characters of a check's name


class Verdict(StrEnum):
    """The verdict of one check."""

    PASSED = "passed"
    FAILED = "failed"
    NOT_APPLICABLE = "not applicable"


class Note(str):
    """A remark of a check about a part that it could not check; it is no fault."""

    __slots__ = ()


class NotApplicable(Exception):
    """Raised by a check that does not apply; its text is the reason."""


@dataclass(frozen=True)
class Result:
    """One check: its name, its verdict, and sentences: the faults, the remarks, or why it does not apply."""

    check: str
    verdict: Verdict
    words: tuple[str, ...] = ()


@dataclass(frozen=True)
class Report:
    """All checks of one robot, in the order in which they were made."""

    robot: str
    results: tuple[Result, ...]

    @property
    def failures(self) -> tuple[Result, ...]:
        """Return the checks that failed."""
        return tuple(r for r in self.results if r.verdict == Verdict.FAILED)

    def of(self, check: str) -> Result:
        """Return the result of one check. Raises LookupError."""
        found = [r for r in self.results if r.check == check]
        if not found:
            raise LookupError(f"no check named {check!r} was made")
        return found[0]

    def text(self) -> str:
        """Return a table that people read."""
        lines = [f"{self.robot}:"]
        for result in self.results:
            words = shortened(result.words) or ("",)
            lines += [f"  {result.check:{WIDE}} {result.verdict:14}  {words[0]}".rstrip()]
            lines += [f"  {'':{WIDE}} {'':14}  {more}" for more in words[1:]]
        counts = ", ".join(f"{sum(r.verdict == v for r in self.results)} {v}" for v in Verdict)
        return "\n".join([*lines, f"  {counts}.", ""])

    def as_json(self) -> str:
        """Return the same for programs."""
        return json.dumps(asdict(self), indent=2) + "\n"


def shortened(words: Iterable[str]) -> tuple[str, ...]:
    """Return each sentence once, and how many are left out."""
    once = tuple(dict.fromkeys(words))
    return once if len(once) <= MOST else (*once[:MOST], f"And {len(once) - MOST} more.")
